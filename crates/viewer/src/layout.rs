//! Open panels, and marks over the picture.

/// Open panels, and marks over the picture.
#[derive(Debug, Clone, PartialEq)]
pub struct WindowLayout {
    /// Spectra and the scene, on the left.
    pub scene: bool,
    /// Picture, method and probe, on the right.
    pub picture: bool,
    /// The timeline, below.
    pub timeline: bool,
    /// True if the list of keys is open.
    pub help: bool,
    /// True if spectra are plotted in logarithms.
    pub logarithmic: bool,
    /// True if places of stars and the frame of the scene's own picture are drawn.
    pub overlay: bool,
    /// True if the picture fills the window, past the frame of the scene's own picture.
    pub fills: bool,
    /// Frame that is drawn over the picture.
    pub guide: Guide,
}

impl Default for WindowLayout {
    fn default() -> Self {
        Self {
            scene: true,
            picture: true,
            timeline: false,
            help: false,
            logarithmic: false,
            overlay: false,
            fills: false,
            guide: Guide::None,
        }
    }
}

/// The name under which the layout is stored.
const KEY: &str = "layout";

impl WindowLayout {
    /// The layout as it was when the last window closed.
    pub fn stored(storage: Option<&dyn eframe::Storage>) -> Self {
        let Some(text) = storage.and_then(|s| s.get_string(KEY)) else { return Self::default() };
        let on = |name: &str| text.split(' ').any(|word| word == name);
        let (scene, picture, timeline) = (on("scene"), on("picture"), on("timeline"));
        Self { scene, picture, timeline, logarithmic: on("logarithmic"), fills: on("fills"), ..Self::default() }
    }

    /// Writes the layout down for the next time.
    pub fn save(&self, storage: &mut dyn eframe::Storage) {
        let open = [
            ("scene", self.scene),
            ("picture", self.picture),
            ("timeline", self.timeline),
            ("logarithmic", self.logarithmic),
            ("fills", self.fills),
        ];
        storage.set_string(KEY, open.iter().filter(|(_, on)| *on).map(|(name, _)| *name).collect::<Vec<_>>().join(" "));
    }
}

/// The frame of a picture that is to be composed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Guide {
    /// No frame is drawn.
    #[default]
    None,
    /// A film or a 4k screen.
    Wide,
    /// The cinema's widest.
    Scope,
    /// A square.
    Square,
    /// The circle of a dome.
    Dome,
}

impl Guide {
    /// All of them, in the order in which G goes through them.
    pub const ALL: [Self; 5] = [Self::None, Self::Wide, Self::Scope, Self::Square, Self::Dome];

    /// The name in menus.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Wide => "16:9 (HD, 4k)",
            Self::Scope => "2.39:1",
            Self::Square => "1:1",
            Self::Dome => "dome",
        }
    }

    /// Width of the frame, of its height.
    pub(crate) fn shape(self) -> Option<f32> {
        match self {
            Self::None => None,
            Self::Wide => Some(16.0 / 9.0),
            Self::Scope => Some(2.39),
            Self::Square | Self::Dome => Some(1.0),
        }
    }
}
