//! `barnard render --frames`: frame after frame of a scene that changes.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, bail};
use barnard::animation::Frames;
use barnard::camera::Camera;
use barnard::control::Control;
use barnard::image::{Image, LayerChoice, Level};
use barnard::plan::{Options, Planned};
use barnard::scene::{Provenance, Scene};
use barnard::sequence::{Follower, FrameImage, FrameSettings, Sequence};
use barnard_files::claim::Claim;
use barnard_files::formats::{check_folder, numbered, replace};
use clap::Args;
use serde_json::json;

use crate::source::SceneArgs;
use crate::verbs::refuse_inputs;
use crate::{counted, outputs, progress};

/// Frames of a sequence to render.
#[derive(Args)]
pub struct FrameArgs {
    /// Frames of an animated scene: all, 1-900, 1-900x10 (every tenth) or a list 1,5,9-12; -o contains the number, as
    /// name_%06d.exr or name_####.exr
    #[arg(long, value_name = "FRAMES", allow_hyphen_values = true)]
    frames: Option<String>,
    /// Part of the frames for this process, such as 3/8: every eighth, from the third on
    #[arg(long, value_name = "I/N", requires = "frames", value_parser = parse_shard)]
    shard: Option<(usize, usize)>,
    /// Render existing frames again
    #[arg(long, requires = "frames")]
    overwrite: bool,
}

fn parse_shard(text: &str) -> Result<(usize, usize), String> {
    let wrong = || "a shard must be I/N with I from 1 to N, such as 3/8".to_owned();
    let (shard, all) = text.split_once('/').ok_or_else(wrong)?;
    match (shard.trim().parse(), all.trim().parse()) {
        (Ok(shard), Ok(all)) if (1..=all).contains(&shard) => Ok((shard, all)),
        _ => Err(wrong()),
    }
}

/// The numbers of frames that `text` means, ascending.
fn parse_frames(text: &str, frames: Frames) -> anyhow::Result<Vec<i64>> {
    let (first, last) = (frames.first, frames.last());
    if text.trim() == "all" {
        return Ok((first..=last).collect());
    }
    let mut numbers = BTreeSet::new();
    for part in text.split(',').map(str::trim) {
        let wrong = || anyhow::anyhow!("--frames {text}: \"{part}\" is not a frame or a range; write 12, 1-900, 1-900x10 or all");
        // Other programs write ranges with a colon, which is a step here.
        if let Some((from, to)) = part.split_once(':').filter(|(from, _)| !from.trim_start_matches('-').contains('-')) {
            bail!("--frames {text}: \"{part}\" is not a range; write {from}-{to}, or {from}-{to}x10 for every tenth");
        }
        let (range, every) = match part.split_once(['x', ':']) {
            Some((range, every)) => (range, every.trim().parse::<usize>().ok().filter(|n| *n > 0).ok_or_else(wrong)?),
            None => (part, 1),
        };
        // A number may be below zero: its sign is no dash between two.
        let dash = range.char_indices().skip(1).find(|(_, c)| *c == '-').map(|(at, _)| at);
        let number = |text: &str| text.trim().parse::<i64>().map_err(|_| wrong());
        let (from, to) = match dash {
            Some(at) => (number(&range[..at])?, number(&range[at + 1..])?),
            None => (number(range)?, number(range)?),
        };
        if from > to {
            bail!("--frames {text}: {from} is after {to}; write {to}-{from}");
        }
        if let Some(outside) = [from, to].into_iter().find(|n| !(first..=last).contains(n)) {
            bail!("--frames {text}: frame {outside} does not exist; the scene has frames {first} to {last}");
        }
        numbers.extend((from..=to).step_by(every));
    }
    Ok(numbers.into_iter().collect())
}

/// Renderer of a planned scene.
pub type March<'a> = &'a mut dyn FnMut(&Planned, &Control) -> anyhow::Result<Image>;

/// A sequence on its way to files.
pub struct Shoot<'a> {
    pub scene: &'a SceneArgs,
    pub sequence: &'a Sequence,
    pub options: &'a Options,
    pub outputs: &'a [PathBuf],
    /// Layers in place of the scene's.
    pub layers: Option<LayerChoice>,
    /// The scene and the settings of its frames, as text: frames of another one are not resumed.
    pub identity: String,
}

impl FrameArgs {
    /// True if frames are requested.
    pub fn is_asked(&self) -> bool {
        self.frames.is_some()
    }

    /// True if the files of a frame exist and stay. A name without a number is that of the last rendered frame.
    fn is_done(&self, shoot: &Shoot, files: &[Vec<PathBuf>]) -> bool {
        !self.overwrite && shoot.are_numbered() && files.iter().flatten().all(|path| path.is_file())
    }

    /// Renders the frames, a line of JSON for each on standard output.
    pub fn render(&self, shoot: &Shoot, march: March) -> anyhow::Result<()> {
        let frames = shoot.sequence.frames();
        let all = parse_frames(self.frames.as_deref().unwrap_or("all"), frames)?;
        let (shard, shards) = self.shard.unwrap_or((1, 1));
        let alone = all.len() == 1;
        let numbers: Vec<i64> = all.iter().copied().skip(shard - 1).step_by(shards).collect();
        let note = progress::Note::default();
        let control = progress::control_with(&note)?;
        let mut follower = Follower::new(shoot.sequence);
        let first = shoot.scene.adjusted(follower.scene(frames.time(frames.first), &control)?, shoot.options.memory_limit, &control)?;
        let first = outputs::layered(first, shoot.layers, shoot.outputs, shoot.options.memory_limit)?;
        let files = |number: i64| shoot.files(number, alone, &first.camera);
        shoot.check(&numbers, &files, &first)?;
        if shoot.are_numbered() {
            let stays = |number: &i64| !self.overwrite || all.binary_search(number).is_err();
            shoot.record(&files, (frames.first..=frames.last()).filter(stays))?;
        }
        let left = numbers.into_iter().map(|number| Ok((number, files(number)?))).collect::<anyhow::Result<Vec<_>>>()?;
        let (done, left): (Vec<_>, Vec<_>) = left.into_iter().partition(|(_, files)| self.is_done(shoot, files));
        for (number, files) in &done {
            Claim::sweep(&files[0][0]);
            report(*number, "exists");
        }
        if left.is_empty() {
            return Ok(());
        }
        if let Some(words) = shoot.sequence.missing_echo(&first)? {
            complain!("warning: {words}");
        }
        note.set("pilot frames".into());
        let shared = shoot.shared(&mut follower, &control)?;
        let (start, mut done, mut elsewhere) = (Instant::now(), 0usize, 0usize);
        for (i, (number, files)) in left.iter().enumerate() {
            let Some(claim) = Claim::of(&files[0][0])? else {
                report(*number, "claimed");
                elsewhere += 1;
                continue;
            };
            if !claim.is_locked() && done == 0 {
                complain!("warning: this file system does not support locks; give each process its own --shard to avoid duplicate work");
            }
            // Another process may have written it in the meantime.
            if self.is_done(shoot, files) {
                report(*number, "exists");
                continue;
            }
            let per_frame = start.elapsed().as_secs_f64() / done.max(1) as f64;
            let rest = (done > 0).then(|| format!(", {} left", progress::duration(per_frame * (left.len() - i) as f64)));
            note.set(format!("frame {number} ({} of {}){}", i + 1, left.len(), rest.unwrap_or_default()));
            shoot.frame(*number, &shared, &mut follower, &control, march).with_context(|| format!("frame {number}"))?;
            done += 1;
            control.check()?;
        }
        complain!("{} rendered in {:.1} s", counted(done, "frame"), start.elapsed().as_secs_f64());
        if elsewhere > 0 {
            complain!("{elsewhere} frames are being rendered by other processes; run again to verify that all exist");
        }
        Ok(())
    }
}

/// Prints the status of a frame as a line of JSON.
fn report(number: i64, status: &str) {
    say!("{}", json!({ "frame": number, "status": status }));
}

impl Shoot<'_> {
    /// Checks that files can be written, and that none is an input of the scene.
    fn check(&self, numbers: &[i64], files: &impl Fn(i64) -> anyhow::Result<Vec<Vec<PathBuf>>>, scene: &Scene) -> anyhow::Result<()> {
        if let Some(number) = numbers.first() {
            // Asked for without a look at what others write there.
            files(*number)?.iter().flatten().try_for_each(|path| check_folder(path))?;
        }
        numbers.iter().try_for_each(|number| refuse_inputs(scene, &files(*number)?.concat()))
    }

    /// Writes whose frames the output folder has, in a hidden file for each name pattern.
    ///
    /// # Errors
    /// If the file is of another scene or other settings, and one of the frames `staying` exists: they would make a mixed film.
    fn record(&self, files: &dyn Fn(i64) -> anyhow::Result<Vec<Vec<PathBuf>>>, staying: impl Iterator<Item = i64>) -> anyhow::Result<()> {
        let digest = Provenance { text: self.identity.as_str().into(), files: Vec::new() }.digest();
        let hidden = |path: &PathBuf| path.with_file_name(format!(".{}.scene", path.file_name().unwrap_or_default().to_string_lossy()));
        let records: Vec<PathBuf> = self.outputs.iter().map(hidden).collect();
        let is_other = |record: &PathBuf| std::fs::read_to_string(record).is_ok_and(|found| found != digest);
        if records.iter().any(is_other) {
            for number in staying {
                if let Some(file) = files(number)?.concat().into_iter().find(|file| file.is_file()) {
                    bail!(
                        "{} was rendered from another scene or with other settings; render all frames again with --frames all --overwrite, or use another folder",
                        file.display()
                    );
                }
            }
        }
        records.iter().try_for_each(|record| Ok(replace(record, digest.as_bytes())?))
    }

    /// True if each frame has files of its own.
    fn are_numbered(&self) -> bool {
        self.outputs.iter().all(|path| numbered(path, 0).is_some())
    }

    /// The files of a frame, those of both eyes together; where it is the only one, names need no number.
    fn files(&self, number: i64, alone: bool, camera: &Camera) -> anyhow::Result<Vec<Vec<PathBuf>>> {
        let file = |path: &PathBuf| match numbered(path, number) {
            Some(file) => outputs::files(&file, camera),
            None if alone => outputs::files(path, camera),
            None => bail!("-o {}: frames require a number in the file name, such as name_%06d.exr", path.display()),
        };
        self.outputs.iter().map(file).collect()
    }

    /// Settings shared by all frames, chosen from the whole sequence.
    fn shared(&self, follower: &mut Follower, control: &Control) -> anyhow::Result<FrameSettings> {
        let shared = FrameSettings::of(
            self.sequence,
            |time| self.scene.uncropped(follower.scene(time, control)?, self.options.memory_limit, control),
            self.options,
            control,
        )?;
        let choices = &shared.choices;
        complain!(
            "settings of all frames, from {} pilot frames: {}, star depths x {}, white {}",
            self.sequence.pilots().len(),
            choices.stepping,
            choices.star_factor,
            match shared.display.white {
                Level::Radiance(white) => format!("{white:.4e}"),
                Level::Auto => "of each frame".into(),
            }
        );
        Ok(shared)
    }

    /// Renders one frame and writes it down.
    fn frame(&self, number: i64, shared: &FrameSettings, follower: &mut Follower, control: &Control, march: March) -> anyhow::Result<()> {
        let begun = Instant::now();
        let adjusted = |scene: Scene| {
            let scene = self.scene.adjusted(scene, self.options.memory_limit, control)?;
            outputs::layered(scene, self.layers, self.outputs, self.options.memory_limit)
        };
        let FrameImage { image, scene, planning_s } = follower.frame(number, (shared, self.options), control, adjusted, march)?;
        let mut files = Vec::new();
        for path in self.outputs {
            let path = numbered(path, number).unwrap_or_else(|| path.clone());
            files.extend(outputs::save(&image, &path, &scene)?.iter().map(|file| file.display().to_string()));
        }
        let seconds = begun.elapsed().as_secs_f64();
        let time = self.sequence.frames().time(number);
        say!(
            "{}",
            json!({ "frame": number, "status": "rendered", "time_s": time, "files": files, "seconds": rounded(seconds), "plan_seconds": rounded(planning_s) })
        );
        Ok(())
    }
}

/// A time as a line of JSON shows it: whole milliseconds.
fn rounded(seconds: f64) -> f64 {
    (1e3 * seconds).round() / 1e3
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_read() {
        let frames = Frames { per_second: 30.0, first: -5, count: 1000, shutter: 0.0, moments: 8 };
        let read = |text: &str| parse_frames(text, frames);
        assert_eq!(read("3").unwrap(), [3]);
        assert_eq!(read("9-12, 1,10").unwrap(), [1, 9, 10, 11, 12]);
        assert_eq!(read("1-30x10").unwrap(), [1, 11, 21]);
        assert_eq!(read("-5--3").unwrap(), [-5, -4, -3]);
        assert_eq!(read("all").unwrap().len(), 1000);
        for (text, words) in [
            ("5-1", "1-5"),
            ("1-995", "-5 to 994"),
            ("x", "not a frame"),
            ("1-9x0", "not a frame"),
            ("", "not a frame"),
            ("1-", "not a frame"),
        ] {
            let error = read(text).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
    }

    #[test]
    fn shards_are_read() {
        assert_eq!((parse_shard("3/8"), parse_shard("9/8").is_err(), parse_shard("0/8").is_err()), (Ok((3, 8)), true, true));
    }
}
