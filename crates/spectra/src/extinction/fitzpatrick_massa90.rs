//! The ultraviolet form of Fitzpatrick & Massa 1990, shared by later laws.
//!
//! E(λ−V)/E(B−V) = c₁ + c₂ x + c₃ x²/((x² − x₀²)² + x² γ²) + c₄ F(x),  F = 0.5392 (x − 5.9)² + 0.05644 (x − 5.9)³ for x
//! > 5.9
//!
//! | symbol | variable | unit |
//! |---|---|---|
//! | x = 1/λ | `x` | µm⁻¹ |
//! | c₁ … c₄ | `c` | 1, µm, µm⁻², 1 |
//! | x₀, γ | `centre`, `width` | µm⁻¹ |
//!
//! Source: ApJS 72, 163, eq. 2, 10.1086/191413.

/// The parameters of one curve.
#[derive(Debug, Clone, Copy)]
pub(super) struct FitzpatrickMassa {
    pub c: [f64; 4],
    pub centre: f64,
    pub width: f64,
}

impl FitzpatrickMassa {
    pub fn at(&self, x: f64) -> f64 {
        let x2 = x * x;
        let bump = x2 / ((x2 - self.centre.powi(2)).powi(2) + x2 * self.width.powi(2));
        let y = (x - 5.9).max(0.0);
        let rise = 0.5392 * y.powi(2) + 0.05644 * y.powi(3);
        self.c[0] + self.c[1] * x + self.c[2] * bump + self.c[3] * rise
    }
}
