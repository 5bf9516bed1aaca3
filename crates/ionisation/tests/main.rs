//! Clouds of ionised gas against what is known of them: one program, so that its tests share the processor.

mod analytic;
mod atoms;
mod cloud;
mod common;
mod lexington;
mod nodes;
mod shadows;
