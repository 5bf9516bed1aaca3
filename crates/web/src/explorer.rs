//! An explorer of one scene.

use std::io::Cursor;

use barnard::Error;
use barnard::backend::cpu;
use barnard::control::Control;
use barnard_explorer::comparison;
use barnard_explorer::document::{Document, Origin};
use barnard_explorer::edit::Edit;
use barnard_explorer::flight::Flight;
use barnard_explorer::order::{Order, Refinement, View};
use barnard_explorer::picture::Picture;
use barnard_explorer::studio::Studio;
use barnard_files::builtin;
use barnard_files::bundle::Bundle;
use barnard_files::formats::writer;
use js_sys::{Array, Function, Object, Reflect, Uint8ClampedArray};
use wasm_bindgen::prelude::{JsError, JsValue, wasm_bindgen};

use crate::{device, files, progress, state};

/// Most bytes of a plan: a browser gives four billion to all.
const MEMORY_LIMIT: u64 = 2 << 30;
/// Voxels along the longest edge of gas that takes too much memory: tried at first, and at least.
const MOST_VOXELS: u32 = 288;
const LEAST_VOXELS: u32 = 64;
/// Numbers below are whole without loss.
const WHOLE: f64 = 9e15;
/// Most pixels along an edge of a picture.
const LARGEST: u32 = 8192;

type Result<T> = std::result::Result<T, JsError>;

fn failed(error: impl std::fmt::Display) -> JsError {
    JsError::new(&error.to_string())
}

/// A scene, the view of it, and its pictures.
#[wasm_bindgen]
pub struct Explorer {
    document: Document,
    flight: Flight,
    studio: Studio,
    /// Count of requests for automatic levels.
    exposure: u64,
    shown: Option<Picture>,
}

#[wasm_bindgen]
impl Explorer {
    /// Opens a text, with the files that were given.
    ///
    /// # Errors
    /// Errors of `barnard check`.
    #[wasm_bindgen(constructor)]
    pub fn new(name: &str, text: &str) -> Result<Self> {
        Ok(Self::of(Document::from_text(name, text.to_owned(), files::given(), MEMORY_LIMIT).map_err(failed)?))
    }

    /// Opens a bundle from its bytes.
    ///
    /// # Errors
    /// If it is damaged, or of another version.
    pub fn bundle(name: &str, bytes: &[u8]) -> Result<Self> {
        let bundle = Bundle::read(Cursor::new(bytes), name.as_ref(), MEMORY_LIMIT).map_err(failed)?;
        Ok(Self::of(Document::from_bundle(Origin::Text(bundle.name.clone()), &bundle, MEMORY_LIMIT).map_err(failed)?))
    }

    /// Opens a built-in scene.
    ///
    /// # Errors
    /// If there is none of that name.
    pub fn builtin(name: &str) -> Result<Self> {
        let entry = builtin::entry(name).map_err(failed)?;
        Self::new(entry.name, entry.text)
    }

    /// The text.
    #[must_use]
    pub fn text(&self) -> String {
        self.document.text().to_owned()
    }

    /// The text with the present view as its camera.
    ///
    /// # Errors
    /// If the view cannot be written.
    pub fn text_with_view(&self) -> Result<String> {
        let mut toml = self.document.toml().clone();
        self.flight.edit().apply(&mut toml);
        Ok(toml.to_string())
    }

    /// The scene as the page shows it, as JSON.
    #[must_use]
    pub fn state(&self) -> String {
        state::scene(&self.document).to_string()
    }

    /// Puts another text in place of this one, as an edit.
    ///
    /// # Errors
    /// Errors of `barnard check`; nothing is changed then.
    pub fn replace(&mut self, text: &str) -> Result<()> {
        self.changed(|document| document.replace(text))
    }

    /// Sets a key of a table, such as "star.0", to a number or a text.
    ///
    /// # Errors
    /// Errors of `barnard check`; nothing is changed then.
    pub fn set(&mut self, place: &str, key: &str, value: &JsValue) -> Result<()> {
        let edit = match (value.as_f64(), value.as_bool(), value.as_string()) {
            // Keys of whole numbers take no fractions, and JavaScript does not tell them apart.
            (Some(number), _, _) if number.fract() == 0.0 && number.abs() < WHOLE => Edit::set(place, key, number as i64),
            (Some(number), _, _) => Edit::set(place, key, number),
            (_, Some(flag), _) => Edit::set(place, key, flag),
            (_, _, Some(text)) => Edit::set(place, key, text),
            _ => Edit::remove(place, key),
        };
        self.changed(|document| document.apply(edit))
    }

    /// Shows the scene through another set of filters, in colours of its own.
    ///
    /// # Errors
    /// If there is none of that name, or the scene has no light in it.
    pub fn filters(&mut self, set: &str) -> Result<()> {
        self.exposure += 1;
        self.changed(|document| document.apply(comparison::filters(set)))
    }

    /// The next edit is one of its own when edits are taken back.
    pub fn rest(&mut self) {
        self.document.rest();
    }

    /// Takes the last edit back.
    ///
    /// # Errors
    /// If the text before is no scene any more.
    pub fn undo(&mut self) -> Result<()> {
        self.changed(Document::undo)
    }

    /// Does the last edit again that was taken back.
    ///
    /// # Errors
    /// If the text is no scene any more.
    pub fn redo(&mut self) -> Result<()> {
        self.changed(Document::redo)
    }

    /// Measures black and white anew.
    ///
    /// # Errors
    /// If the text without levels is no scene.
    pub fn expose(&mut self) -> Result<()> {
        self.exposure += 1;
        let automatic = Edit::remove("display", "white").and(Edit::remove("display", "black"));
        self.changed(|document| document.apply(automatic))
    }

    /// Levels of the latest final picture, if there is one since they were asked for: white, then columns of the palette.
    #[must_use]
    pub fn levels(&self) -> Option<Vec<f64>> {
        self.studio.levels(self.exposure)
    }

    /// Shows pictures by levels of another explorer of this scene, or measures them anew.
    pub fn take_levels(&mut self, levels: Option<Vec<f64>>) {
        self.studio.take_levels(self.exposure, self.document.scene(), levels.as_deref());
    }

    /// Makes the picture brighter by a number of stops.
    ///
    /// # Errors
    /// If nothing is shown yet.
    pub fn brighten(&mut self, stops: f64) -> Result<()> {
        let white = self.shown.as_ref().ok_or_else(|| failed("nothing is shown yet"))?.tone.white * (-stops).exp2();
        self.changed(|document| document.apply(Edit::set("display", "white", white).with_name("exposure")))
    }

    /// Turns the view around the middle of motion, by parts of its width.
    pub fn orbit(&mut self, right: f64, down: f64) {
        self.flight.orbit(right, down);
    }

    /// Turns the eye where it is, by parts of the view's width.
    pub fn look(&mut self, right: f64, down: f64) {
        self.flight.look(right, down);
    }

    /// Moves across the view, by parts of its width.
    pub fn pan(&mut self, right: f64, down: f64) {
        self.flight.pan(right, down);
    }

    /// Multiplies the distance to the middle of motion.
    pub fn approach(&mut self, factor: f64) {
        self.flight.approach(factor);
    }

    /// Flies right, up and forward, in seconds of flight.
    pub fn fly(&mut self, right: f64, up: f64, forward: f64) {
        self.flight.fly(right, up, forward);
    }

    /// Multiplies the field of view.
    pub fn widen(&mut self, factor: f64) {
        self.flight.widen(factor);
    }

    /// Goes back to the scene's own view.
    pub fn home(&mut self) {
        self.flight = Flight::of(self.document.scene());
    }

    /// Goes to a bookmark of the scene.
    ///
    /// # Errors
    /// If it has none of that name.
    pub fn bookmark(&mut self, name: &str) -> Result<()> {
        let scene = self.document.scene().clone();
        let camera = scene.bookmarks.get(name).ok_or_else(|| failed(format!("the scene has no bookmark {name}")))?;
        self.flight.take(&scene, camera);
        Ok(())
    }

    /// Shows another moment of a scene that changes \[s\].
    ///
    /// # Errors
    /// If the scene cannot be at that moment.
    pub fn moment(&mut self, seconds: f64) -> Result<()> {
        let is_flown = self.document.moves_camera();
        self.changed(|document| document.show_moment(seconds))?;
        if is_flown {
            self.home();
        }
        Ok(())
    }

    /// Computes the gas exactly where it is known roughly. `heard` is called with the stage and the finished share \[1\].
    /// Gas that takes more memory than a browser has is computed on fewer voxels, by an edit of this explorer's text alone; the result is
    /// their number along the longest edge, if so.
    ///
    /// # Errors
    /// If it cannot be computed.
    pub fn refine(&mut self, heard: &Function) -> Result<Option<u32>> {
        let mut voxels = None;
        while self.document.is_rough() {
            match self.document.refine_now(&progress::control(heard)) {
                Ok(()) => {}
                Err(Error::Memory { .. }) if voxels.is_none_or(|voxels| voxels > LEAST_VOXELS) => {
                    let fewer = voxels.map_or(MOST_VOXELS, |voxels| voxels * 2 / 3);
                    self.document.apply(Edit::set("gas", "voxels", i64::from(fewer))).map_err(failed)?;
                    voxels = Some(fewer);
                }
                Err(error) => return Err(failed(error)),
            }
        }
        Ok(voxels)
    }

    /// Makes pictures of `width` × `height` pixels, from coarse to fine: a single quick one where things are moving, and the one of
    /// `barnard render` at last where the gas is known exactly. `show` is called with each, `heard` with progress.
    ///
    /// # Errors
    /// If the size is none, or the scene cannot be rendered.
    pub async fn render(&mut self, width: u32, height: u32, moving: bool, show: Function, heard: Function) -> Result<()> {
        if !(1..=LARGEST).contains(&width) || !(1..=LARGEST).contains(&height) {
            return Err(failed(format!("a picture must have 1 to {LARGEST} pixels along each edge, not {width} x {height}")));
        }
        let order = Order {
            views: vec![View::of(&self.document)],
            camera: self.flight.seen((width as usize, height as usize)),
            moving,
            settles: !self.document.is_rough(),
            difference: false,
            exposure: self.exposure,
            memory_limit: MEMORY_LIMIT,
        };
        let (shown, mut failure) = (&mut self.shown, None);
        let control = progress::control(&heard);
        let mut show_latest = |quality, mut pictures: Vec<Picture>| {
            if let Some(picture) = pictures.pop() {
                failure = show.call1(&JsValue::NULL, &message(quality, &picture)).err();
                *shown = Some(picture);
            }
        };
        self.studio.serve_async(&order, &control, &mut show_latest).await.map_err(failed)?;
        failure.map_or(Ok(()), |error| Err(failed(format!("the page could not show a picture: {error:?}"))))
    }

    /// Values, optical depth and spectrum of a pixel of the last picture, as JSON. Coordinates are fractions of width and height \[1\].
    ///
    /// # Errors
    /// If nothing is shown yet.
    pub fn probe(&self, right: f64, down: f64) -> Result<String> {
        let picture = self.shown.as_ref().ok_or_else(|| failed("nothing is shown yet"))?;
        let place = |part: f64, count: usize| ((part * count as f64).max(0.0) as usize).min(count - 1);
        Ok(state::pixel(picture, (place(right, picture.image.width), place(down, picture.image.height))).to_string())
    }

    /// The last picture as a file of a format such as "png", "fits", "exr", "tif" or "npy".
    ///
    /// # Errors
    /// If nothing is shown yet, or there is no such format.
    pub fn encoded(&self, format: &str) -> Result<Vec<u8>> {
        let picture = self.shown.as_ref().ok_or_else(|| failed("nothing is shown yet"))?;
        let writer = writer(format!("picture.{format}").as_ref()).map_err(failed)?;
        (writer.encode)(&picture.image, &picture.scene.save_options()).map_err(failed)
    }
}

/// Studio on the device of the browser, if it is open, otherwise on the processor.
fn studio() -> Studio {
    let mut studio = Studio::new(cpu::ENTRY, None, Control::default()).without_plates();
    if let Some(device) = device::lent() {
        studio.take(device);
    }
    studio
}

impl Explorer {
    fn of(document: Document) -> Self {
        Self { flight: Flight::of(document.scene()), document, studio: studio(), exposure: 0, shown: None }
    }

    /// Changes the document; the view follows its camera.
    fn changed(&mut self, change: impl FnOnce(&mut Document) -> barnard::Result<()>) -> Result<()> {
        let before = self.document.scene().clone();
        change(&mut self.document).map_err(failed)?;
        let scene = self.document.scene();
        if scene.camera != before.camera {
            self.flight.take(scene, &scene.camera);
        }
        Ok(())
    }
}

/// A picture as a message to the page: its colours, and stars over it if it has none.
fn message(quality: Refinement, picture: &Picture) -> Object {
    let quality = match quality {
        Refinement::Coarse | Refinement::Full => "preview",
        Refinement::Exposed | Refinement::Settled => "final",
    };
    let rgba = |colours: &[[u8; 4]]| JsValue::from(Uint8ClampedArray::from(colours.as_flattened()));
    let sparks = picture.sparks.as_ref().map_or(JsValue::NULL, |sparks| {
        let [width, height] = sparks.size.map(|n| JsValue::from(n as u32));
        Array::of3(&width, &height, &rgba(&sparks.colours)).into()
    });
    let object = Object::new();
    let entries = [
        ("quality", JsValue::from(quality)),
        ("width", JsValue::from(picture.image.width as u32)),
        ("height", JsValue::from(picture.image.height as u32)),
        ("pixels", rgba(&picture.colours)),
        ("sparks", sparks),
        ("seconds", JsValue::from(picture.times.all())),
        ("backend", JsValue::from(&picture.backend)),
    ];
    for (key, value) in entries {
        // Setting a key of a plain object does not fail.
        let _ = Reflect::set(&object, &key.into(), &value);
    }
    object
}
