use barnard::backend::{Renderer, cpu};
use barnard::fixtures::MemoryCache;

use super::*;
use crate::document::Document;
use crate::edit::Edit;
use crate::flight::Flight;

fn order(document: &Document, size: (usize, usize), moving: bool) -> Order {
    let view = View::of(document);
    Order {
        views: vec![view],
        camera: Flight::of(document.scene()).seen(size),
        moving,
        settles: true,
        difference: false,
        exposure: 0,
        memory_limit: 1 << 32,
    }
}

fn served(studio: &mut Studio, order: &Order) -> Vec<(Refinement, Picture)> {
    let mut shown = Vec::new();
    studio.serve(order, &Control::default(), &mut |quality, pictures| shown.extend(pictures.into_iter().map(|p| (quality, p)))).unwrap();
    shown
}

/// The settled picture is that of `barnard render`, pixel by pixel; the quick ones on the way look like it.
#[test]
fn pictures_settle_to_what_is_rendered() {
    let document = Document::builtin("barres_neyret", 1 << 32).unwrap();
    let order = order(&document, (60, 40), false);
    let shown = served(&mut Studio::new(cpu::ENTRY, None, Control::default()), &order);
    let (quality, last) = shown.last().unwrap();
    assert_eq!(*quality, Refinement::Settled);
    let scene = seen(document.scene(), &order.camera);
    let plan = Planner::new(&Options::within(1 << 32)).plan(scene.clone(), None, &Control::default()).unwrap();
    let rendered = Renderer::new(&mut cpu::Cpu).render(&plan, &Control::default()).unwrap().0;
    assert!(*last.image == rendered);
    let (_, full) = shown.iter().rev().find(|(q, _)| *q == Refinement::Full).unwrap();
    for band in 0..3 {
        let difference = full.image.relative_rmse(band, &rendered, band);
        assert!((1e-6..0.15).contains(&difference), "band {band}: {difference}");
    }
}

/// A scene that is known roughly is not rendered in full: what is exact would throw the picture away.
#[test]
fn rough_scenes_get_quick_pictures() {
    let document = Document::builtin("barres_neyret", 1 << 32).unwrap();
    let order = Order { settles: false, ..order(&document, (40, 30), false) };
    let mut studio = Studio::new(cpu::ENTRY, None, Control::default());
    assert_eq!(served(&mut studio, &order).last().unwrap().0, Refinement::Full);
    assert_eq!(served(&mut studio, &Order { settles: true, ..order }).last().unwrap().0, Refinement::Settled);
}

/// Light of all scatterings that a cache holds is not solved again when the window opens anew; previews write nothing there.
#[test]
fn settled_pictures_come_from_the_cache() {
    let mut document = Document::builtin("barres_neyret", 1 << 32).unwrap();
    document.apply(Edit::set("method", "bounces", 1000)).unwrap();
    document.apply(Edit::set("method", "accuracy", 0.05)).unwrap();
    document.apply(Edit::set("method", "bake", 16)).unwrap();
    let cache = Arc::new(MemoryCache::default());
    let settled = |moving: bool| {
        let mut studio = Studio::new(cpu::ENTRY, Some(cache.clone()), Control::default());
        served(&mut studio, &order(&document, (24, 16), moving)).pop().unwrap().1.image
    };
    settled(true);
    assert_eq!(cache.counts(), (0, 0));
    let (first, made) = (settled(false), cache.counts());
    let (second, found) = (settled(false), cache.counts());
    assert!(made.0 == 0 && found == (made.1, 0) && found.0 > 0 && first == second, "{made:?} {found:?}");
}

/// Another stretch colours the picture anew, coarse as it is, and marches nothing; another temperature marches, and
/// keeps what places decided.
#[test]
fn what_has_not_changed_stays() {
    let mut document = Document::builtin("barres_neyret", 1 << 32).unwrap();
    let mut studio = Studio::new(cpu::ENTRY, None, Control::default());
    let first = served(&mut studio, &order(&document, (40, 30), true));
    document.apply(Edit::set("display", "stretch", "linear")).unwrap();
    let shown = served(&mut studio, &order(&document, (40, 30), true));
    assert!(shown.len() == 1 && Arc::ptr_eq(&shown[0].1.image, &first.last().unwrap().1.image));
    assert!(shown[0].1.colours != first.last().unwrap().1.colours);
    document.apply(Edit::set("star.0", "temperature", "4000 K")).unwrap();
    let hotter = served(&mut studio, &order(&document, (40, 30), true));
    assert!(Arc::ptr_eq(hotter[0].1.plan.space(), first[0].1.plan.space()) && hotter[0].1.image != first[0].1.image);
}

/// While a spectrum or the amount of dust changes, the picture is that of `barnard render` at once, all pixels and stars of it; beyond
/// what plates reach it is a preview again.
#[test]
fn spectra_change_settled_pictures() {
    let mut document = Document::builtin("barres_neyret", 1 << 32).unwrap();
    let mut studio = Studio::new(cpu::ENTRY, None, Control::default());
    served(&mut studio, &order(&document, (40, 30), false));
    for (section, key, value) in [
        ("star.0", "temperature", "4000 K"),
        ("star.0", "temperature", "25000 K"),
        ("dust", "scale", "2.2 /pc"),
        ("dust", "scale", "7.5 /pc"),
    ] {
        document.apply(Edit::set(section, key, value)).unwrap();
        let order = order(&document, (40, 30), true);
        let shown = served(&mut studio, &order);
        let [(Refinement::Exposed, picture)] = &shown[..] else { panic!("{}", shown.len()) };
        let scene = seen(document.scene(), &order.camera);
        let plan = Planner::new(&Options::within(1 << 32)).plan(scene.clone(), None, &Control::default()).unwrap();
        let rendered = Renderer::new(&mut cpu::Cpu).render(&plan, &Control::default()).unwrap().0;
        for band in 0..3 {
            let difference = picture.image.relative_rmse(band, &rendered, band);
            assert!((1e-9..2e-3).contains(&difference), "band {band}: {difference}");
        }
    }
    let last = served(&mut studio, &order(&document, (40, 30), false)).pop().unwrap();
    assert!(last.0 == Refinement::Settled);
    document.apply(Edit::set("dust", "scale", "40 /pc")).unwrap();
    let shown = served(&mut studio, &order(&document, (40, 30), true));
    assert!(shown.iter().all(|(quality, _)| *quality < Refinement::Exposed));
    document.apply(Edit::set("dust", "scale", "4 /pc").and(Edit::set("method", "bounces", 3))).unwrap();
    served(&mut studio, &order(&document, (40, 30), false));
    document.apply(Edit::set("star.0", "temperature", "12000 K")).unwrap();
    let shown = served(&mut studio, &order(&document, (40, 30), true));
    assert!(shown.len() == 1 && shown[0].0 == Refinement::Exposed);
}

/// Recorded data accompany their picture; another exposure records it anew, and marches nothing.
#[test]
fn pictures_are_recorded() {
    let mut document = Document::builtin("barres_neyret", 1 << 32).unwrap();
    let mut studio = Studio::new(cpu::ENTRY, None, Control::default());
    document
        .apply(Edit::set("instrument", "preset", "lco-1m-sinistro").and(Edit::set("instrument", "mosaic", toml_edit::Array::new())))
        .unwrap();
    let recorded = |document: &Document| {
        let view = View::of(document);
        Order { views: vec![view.clone(), View { recorded: true, ..view }], ..order(document, (40, 30), false) }
    };
    let mut last = |document: &Document| {
        let shown = served(&mut studio, &recorded(document));
        let mut settled = shown.into_iter().filter(|(quality, _)| *quality == Refinement::Settled).map(|(_, picture)| picture);
        let pair = (settled.next().unwrap(), settled.next().unwrap());
        assert!(settled.next().is_none());
        pair
    };
    let (settled, seen) = last(&document);
    assert!(seen.image.width <= settled.image.width && seen.recorded_words().contains("pixels summed"), "{}", seen.recorded_words());
    // Noise: of a picture, what differs between a pixel and its neighbours beyond what differs there in a thousand times as long.
    let rough = |picture: &Picture| {
        let width = picture.image.width;
        let row: Vec<f64> = (0..width).map(|x| picture.image.at(1, picture.image.height / 2, x)).collect();
        row.windows(3).map(|v| (v[0] - 2.0 * v[1] + v[2]).powi(2)).sum::<f64>().sqrt()
    };
    document.apply(Edit::set("instrument", "exposure", "1e-7 s")).unwrap();
    let (again, short) = last(&document);
    assert!(Arc::ptr_eq(&settled.image, &again.image) && rough(&short) > 10.0 * rough(&seen), "{} {}", rough(&short), rough(&seen));
    // Other colours leave the noise as it is.
    document.apply(Edit::set("display", "stretch", "linear")).unwrap();
    let (_, linear) = last(&document);
    assert!(Arc::ptr_eq(&linear.image, &short.image) && linear.colours != short.colours);
    document.apply(Edit::set("camera", "kind", "fisheye").and(Edit::remove("camera", "field_of_view"))).unwrap();
    let mut shown = Vec::new();
    let failed = studio.serve(&recorded(&document), &Control::default(), &mut |quality, pictures| shown.push((quality, pictures.len())));
    assert!(failed.unwrap_err().to_string().contains("perspective") && shown.last() == Some(&(Refinement::Settled, 2)));
}

/// A worker that is closed gives up its first look as well.
#[test]
fn closing_stops_a_first_look() {
    let document = Document::builtin("barres_neyret", 1 << 32).unwrap();
    let closing = Control::default();
    closing.interrupt();
    let mut studio = Studio::new(cpu::ENTRY, None, closing);
    let served = studio.serve(&order(&document, (48, 32), true), &Control::default(), &mut |_, _| panic!("a picture"));
    assert!(matches!(served, Err(Error::Interrupted)));
}
