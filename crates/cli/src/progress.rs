//! Progress of long work: a bar on a terminal, plain lines otherwise; Ctrl-C stops it cleanly.

use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use barnard::control::{Control, Stage};
use indicatif::{ProgressBar, ProgressStyle};

fn words(stage: Stage) -> &'static str {
    match stage {
        Stage::StarDepths => "star depths",
        Stage::Light => "light field",
        Stage::Rays => "rays",
    }
}

/// A control that shows progress and hears Ctrl-C.
pub fn control() -> anyhow::Result<Control> {
    let control = if std::io::stderr().is_terminal() { with_bar() } else { with_lines() };
    let handle = control.clone();
    ctrlc::set_handler(move || handle.interrupt())?;
    Ok(control)
}

fn with_bar() -> Control {
    let style = ProgressStyle::with_template("{msg:12} {bar:40.cyan/black} {percent:>3} %  {eta} left")
        .unwrap_or_else(|_| ProgressStyle::default_bar())
        .progress_chars("█▉▊▋▌▍▎▏ ");
    let bar = Mutex::new(None::<(Stage, ProgressBar)>);
    Control::with_listener(move |stage, done, all| {
        let Ok(mut current) = bar.lock() else { return };
        if current.as_ref().is_none_or(|(s, _)| *s != stage) {
            if let Some((_, old)) = current.take() {
                old.finish_and_clear();
            }
            *current = Some((stage, ProgressBar::new(all).with_style(style.clone()).with_message(words(stage))));
        }
        if let Some((_, bar)) = current.as_ref() {
            bar.set_length(all);
            bar.set_position(done.max(bar.position()));
            if done >= all {
                bar.finish_and_clear();
            }
        }
    })
}

/// A line at most every ten seconds.
fn with_lines() -> Control {
    let last = Mutex::new(Instant::now());
    Control::with_listener(move |stage, done, all| {
        let Ok(mut last) = last.lock() else { return };
        if last.elapsed() > Duration::from_secs(10) {
            *last = Instant::now();
            complain!("{}: {} %", words(stage), 100 * done / all.max(1));
        }
    })
}
