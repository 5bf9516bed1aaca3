//! Progress of long work: a bar on a terminal, plain lines otherwise; Ctrl-C stops it cleanly.

use std::io::IsTerminal;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use barnard::control::{Control, Stage};
use indicatif::{ProgressBar, ProgressStyle};

/// Words that stand beside the progress, such as an error that falls.
#[derive(Clone, Default)]
pub struct Note(Arc<Mutex<String>>);

impl Note {
    /// Other words from now on.
    pub fn set(&self, words: String) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = words;
    }

    fn words(&self) -> String {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// A control that shows progress and stops on Ctrl-C.
pub fn control() -> anyhow::Result<Control> {
    control_with(&Note::default())
}

/// A control like [`control`], with words beside the bar.
pub fn control_with(note: &Note) -> anyhow::Result<Control> {
    let control = if std::io::stderr().is_terminal() { with_bar(note.clone()) } else { with_lines(note.clone()) };
    let mut current = CURRENT.lock().unwrap_or_else(PoisonError::into_inner);
    if current.replace(control.clone()).is_none() {
        ctrlc::set_handler(|| CURRENT.lock().unwrap_or_else(PoisonError::into_inner).iter().for_each(Control::interrupt))?;
    }
    Ok(control)
}

/// The work that Ctrl-C stops.
static CURRENT: Mutex<Option<Control>> = Mutex::new(None);

fn with_bar(note: Note) -> Control {
    let style = ProgressStyle::with_template("{msg:12} {bar:40.cyan/black} {percent:>3} %  {prefix}")
        .unwrap_or_else(|_| ProgressStyle::default_bar())
        .progress_chars("█▉▊▋▌▍▎▏ ");
    let bar = Mutex::new(None::<(Stage, ProgressBar, Instant)>);
    Control::with_listener(move |stage, done, all| {
        let Ok(mut current) = bar.lock() else { return };
        if current.as_ref().is_none_or(|(s, ..)| *s != stage) {
            if let Some((_, old, _)) = current.take() {
                old.finish_and_clear();
            }
            *current = Some((stage, ProgressBar::new(all).with_style(style.clone()).with_message(stage.name()), Instant::now()));
        }
        if let Some((_, bar, since)) = current.as_ref() {
            bar.set_length(all);
            bar.set_position(done.max(bar.position()));
            bar.set_prefix(format!("{}{}", time_left(since.elapsed(), done as f64 / all.max(1) as f64), note.words()));
            if done >= all {
                bar.finish_and_clear();
            }
        }
    })
}

/// A line at most every ten seconds, with the remaining time of the stage.
fn with_lines(note: Note) -> Control {
    let state = Mutex::new((Instant::now(), None::<(Stage, Instant)>));
    Control::with_listener(move |stage, done, all| {
        let Ok(mut state) = state.lock() else { return };
        let (last, begun) = &mut *state;
        let since = match begun {
            Some((current, since)) if *current == stage => *since,
            _ => begun.insert((stage, Instant::now())).1,
        };
        if last.elapsed() > Duration::from_secs(10) {
            *last = Instant::now();
            let share = (done as f64 / all.max(1) as f64).min(1.0);
            complain!("{}: {:.0} %  {}{}", stage.name(), 100.0 * share, time_left(since.elapsed(), share), note.words());
        }
    })
}

/// The remaining time of a stage in words; nothing at its beginning, where an estimate would be far off.
fn time_left(elapsed: Duration, share: f64) -> String {
    if elapsed < Duration::from_secs(2) || share < 0.05 {
        return String::new();
    }
    format!("about {} left  ", duration(elapsed.as_secs_f64() * (1.0 - share.min(1.0)) / share))
}

/// A duration in words.
pub fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 90.0 => format!("{s:.0} s"),
        s if s < 5400.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}
