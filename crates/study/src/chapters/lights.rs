//! Many lights.

use barnard::control::Control;

use super::scene::{Contender, Run, error, error_away_from_stars};
use crate::page::{short, table};
use crate::{Axis, Chapter, Figure, Findings, Result, Series};

pub(super) const CHAPTER: Chapter = Chapter {
    name: "lights",
    title: "5. Many lights",
    question: "1 to 64 stars in one cloud: how long does a frame take with star depths per star, and with all light stored in voxels as polynomials? How large is the error of the latter?",
    run,
};

const STARS: [usize; 4] = [1, 4, 16, 64];
const METHODS: [(&str, usize); 3] = [("band_quadrature", 2), ("projection", 4), ("propagation", 4)];
/// Voxels an edge, pixels an edge of what is timed and of what is compared with the reference, and most stars for that.
const BAKE: usize = 64;
const EDGE: usize = 192;
const COMPARED: usize = 16;
const COMPARED_STARS: usize = 16;

fn run(control: &Control) -> Result<Findings> {
    let mut seconds: Vec<Series> = METHODS.iter().map(|(name, n)| Series { name: format!("{name} {n}"), points: Vec::new() }).collect();
    let (mut errors, mut rows) = (seconds.clone(), Vec::new());
    for stars in STARS {
        let mut run = Run::new(stars, None, BAKE, EDGE)?;
        let (mut times, mut plans) = (Vec::new(), Vec::new());
        for ((method, count), series) in METHODS.iter().zip(&mut seconds) {
            control.check()?;
            let plan = run.plan(&Contender::new(method, Some(*count)), control)?;
            times.push(run.seconds(&plan, control)?);
            series.points.push((stars as f64, times[times.len() - 1]));
            plans.push(plan);
        }
        let mut wrong = vec!["-".to_owned(); METHODS.len()];
        if stars <= COMPARED_STARS {
            run.resized(COMPARED);
            let truth = run.reference(control)?;
            for (i, plan) in plans.into_iter().enumerate() {
                let image = run.image(plan, control)?;
                errors[i].points.push((stars as f64, error(&image, &truth)));
                wrong[i] = format!("{} ({})", short(error(&image, &truth)), short(error_away_from_stars(&image, &truth)));
            }
        }
        let mut row = vec![stars.to_string()];
        times.iter().zip(&wrong).for_each(|(t, e)| row.extend([short(*t), e.clone()]));
        rows.push(row);
    }
    let growth = |s: &Series, from: usize| s.points[s.points.len() - 1].1 / s.points[from].1;
    let text = format!(
        "Barrès & Neyret's cloud on {BAKE}³ voxels, {EDGE} × {EDGE} pixels, N = 100; errors are relative rms of the worst band against the reference on {COMPARED} × {COMPARED} pixels, in brackets without \
         the brightest 5 % of the pixels, next to stars.\n\n{}\
         From 1 to 64 stars a frame takes {:.0} times as long with band quadrature, {:.0} times with projection and {:.1} times with propagation, there {:.1} times from 4 stars on: \
         its numbers per voxel grow until all six temperatures occur. Its error comes from the interpolation of 1/r² \
         between voxels, within a few voxels of each star, and from isotropic scattering.\n",
        table(&["stars", "band_quadrature 2 [s]", "error", "projection 4 [s]", "error", "propagation 4 [s]", "error"], &rows),
        growth(&seconds[0], 0),
        growth(&seconds[1], 0),
        growth(&seconds[2], 0),
        growth(&seconds[2], 1)
    );
    let x = Axis::log("stars");
    let figures = vec![
        Figure {
            name: "lights_time".into(),
            title: "Time of a frame against the number of stars".into(),
            x: x.clone(),
            y: Axis::log("frame [s]"),
            series: seconds,
        },
        Figure {
            name: "lights_error".into(),
            title: "Error against the number of stars".into(),
            x,
            y: Axis::log("relative rms error"),
            series: errors,
        },
    ];
    Ok(Findings { figures, text, ..Findings::default() })
}
