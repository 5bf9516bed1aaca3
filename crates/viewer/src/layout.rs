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
    /// The panel of a window too narrow for both, if any.
    pub only: Option<Side>,
}

/// A panel beside the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Spectra and the scene, on the left.
    Scene,
    /// Picture, method and probe, on the right.
    Picture,
}

/// Width from which a window has both panels beside the picture \[points\].
const ROOM: f32 = 900.0;
/// Width of a panel relative to the window, and its range in a new window \[points\].
const SHARE: f32 = 0.23;
const WIDTHS: (f32, f32) = (306.0, 340.0);
/// Largest width of one of two panels, and of a single one, relative to the window.
const LARGEST: (f32, f32) = (0.32, 0.48);

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
            only: None,
        }
    }
}

/// The name under which the layout is stored.
const KEY: &str = "layout";

impl WindowLayout {
    /// True if a window of a width \[points\] shows a panel: both fit into a wide one, one at a time into a narrow one.
    pub fn shows(&self, side: Side, width: f32) -> bool {
        match side {
            _ if width < ROOM => self.only == Some(side),
            Side::Scene => self.scene,
            Side::Picture => self.picture,
        }
    }

    /// Opens or closes a panel of a window of a width \[points\].
    pub fn toggle(&mut self, side: Side, width: f32) {
        let opens = !self.shows(side, width);
        self.only = opens.then_some(side);
        if width >= ROOM {
            match side {
                Side::Scene => self.scene = opens,
                Side::Picture => self.picture = opens,
            }
        }
    }

    /// Width of a panel in a new window of a width, and its largest width \[points\].
    pub fn widths(width: f32) -> (f32, f32) {
        let largest = width * if width < ROOM { LARGEST.1 } else { LARGEST.0 };
        ((SHARE * width).clamp(WIDTHS.0, WIDTHS.1).min(largest), largest)
    }

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

#[cfg(test)]
mod tests {
    use super::*;

    /// A wide window has both panels; a narrow one begins without and shows the one opened last; widened, both are back.
    #[test]
    fn panels_yield_to_the_picture() {
        let mut layout = WindowLayout::default();
        let shown = |layout: &WindowLayout, width: f32| [Side::Scene, Side::Picture].map(|side| layout.shows(side, width));
        assert_eq!((shown(&layout, 1280.0), shown(&layout, 640.0)), ([true; 2], [false; 2]));
        layout.toggle(Side::Picture, 640.0);
        assert_eq!(shown(&layout, 640.0), [false, true]);
        layout.toggle(Side::Scene, 640.0);
        assert_eq!((shown(&layout, 640.0), shown(&layout, 1280.0)), ([true, false], [true; 2]));
        layout.toggle(Side::Scene, 640.0);
        layout.toggle(Side::Picture, 1280.0);
        assert_eq!((shown(&layout, 640.0), shown(&layout, 1280.0)), ([false; 2], [true, false]));
        for width in [320.0, 640.0, 899.0, 900.0, 1280.0, 3840.0] {
            let (first, largest) = WindowLayout::widths(width);
            assert!(first <= largest && 2.0 * largest < width, "{width}: {first} {largest}");
        }
    }
}
