//! Random scenes whose gas glows: the scenes of [`super::slabs`] with their light within the dust, marched in few thick
//! steps.

use super::slabs::{LightPlace, campaign};
use crate::Chapter;

pub const CHAPTER: Chapter = Chapter {
    name: "glow",
    title: "Certificates for gas within dust",
    question: "Does a stated spectral error hold for light that comes from within the dust, whose mean over every segment is an integral over depth as well? Random laws, filters, \
               continua, methods, accuracies and depths; gas in a box of uniform dust, rendered by `cpu` in 1 to 40 steps, is compared with independent integrals over wavelength.",
    run: |control| campaign(LightPlace::Within, control),
};
