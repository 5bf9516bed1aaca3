//! Commands: what panels, keys and the pointer request of the window, done in their order once a frame is drawn.

use crate::files::Purpose;
use crate::layout::WindowLayout;
use barnard_explorer::comparison::{Arrangement, With};
use barnard_explorer::document::Origin;
use barnard_explorer::edit::Edit;
use barnard_explorer::flight::Flight;
use barnard_explorer::probe::Probed;

/// A request to the window.
#[non_exhaustive]
pub enum Command {
    /// Changes the text of the scene.
    Edit(Edit),
    /// Takes the last edit back.
    Undo,
    /// Does the last edit again that was taken back.
    Redo,
    /// Opens another scene, after a question if changes would be lost.
    Open(Origin),
    /// Saves the scene to its own file, or asks for one.
    Save,
    /// Asks for a file.
    Ask(Purpose),
    /// Compares the picture with another.
    Compare(With),
    /// Arranges two pictures in the window.
    Arrange(Arrangement),
    /// Moves the edge between two pictures, to a part of the width.
    MoveEdge(f32),
    /// Makes the picture brighter, in stops.
    Expose(f64),
    /// Sets black and white from the picture.
    ExposeAutomatically,
    /// Moves the observer.
    Fly(Box<dyn FnOnce(&mut Flight)>),
    /// Shows the whole cloud.
    FrameAll,
    /// Plays a flight into the cloud.
    Visit,
    /// Marks a star, or none.
    Select(Option<usize>),
    /// Sets a bookmark to the view.
    SetBookmark(String),
    /// Goes to a bookmark.
    GoTo(String),
    /// Shows another moment \[s\].
    Seek(f64),
    /// Plays the animation, or stops it.
    Play,
    /// Sets a camera key from the view.
    SetKey,
    /// Removes the nearest camera key.
    DropKey,
    /// Makes camera keys of all bookmarks.
    KeysOfBookmarks,
    /// Opens and closes panels and marks.
    Layout(Box<dyn FnOnce(&mut WindowLayout)>),
    /// Moves the probe to a point of the picture, as fractions of its width and height; `None` removes it.
    Point(Option<(f64, f64)>),
    /// Keeps the spectrum that the probe found.
    Keep(Probed),
    /// Shows a message.
    Tell(String),
    /// Closes the message.
    CloseMessage,
}

/// The commands of one frame.
#[derive(Default)]
pub struct Commands(Vec<Command>);

impl Commands {
    /// Adds a command.
    pub fn push(&mut self, command: impl Into<Command>) {
        self.0.push(command.into());
    }

    /// Moves the observer.
    pub fn fly(&mut self, change: impl FnOnce(&mut Flight) + 'static) {
        self.push(Command::Fly(Box::new(change)));
    }

    /// Opens or closes panels and marks.
    pub fn lay_out(&mut self, change: impl FnOnce(&mut WindowLayout) + 'static) {
        self.push(Command::Layout(Box::new(change)));
    }
}

impl From<Edit> for Command {
    fn from(edit: Edit) -> Self {
        Self::Edit(edit)
    }
}

impl IntoIterator for Commands {
    type Item = Command;
    type IntoIter = std::vec::IntoIter<Command>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter()
    }
}
