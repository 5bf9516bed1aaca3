//! Estimates of the path tracer so far: for each pixel and band how many, their mean and the scatter around it (Welford
//! 1962).

/// The estimate of one pixel in one band.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Estimate {
    /// The number of paths.
    pub count: u64,
    /// The mean of what the paths brought [W m⁻² sr⁻¹].
    pub mean: f64,
    /// Σ (x − mean)², from which the standard error follows.
    pub scatter: f64,
}

impl Estimate {
    /// Takes in what one more path brought.
    pub fn add(&mut self, value: f64) {
        self.count += 1;
        let from_mean = value - self.mean;
        self.mean += from_mean / self.count as f64;
        self.scatter += from_mean * (value - self.mean);
    }

    /// Standard error of the mean; infinite before two paths.
    pub fn error(&self) -> f64 {
        if self.count < 2 { f64::INFINITY } else { (self.scatter / ((self.count - 1) * self.count) as f64).sqrt() }
    }
}

/// The estimates of all pixels, bands × height × width, and the number of paths that brought no number.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Film {
    /// The estimate of each pixel, bands × height × width.
    pub estimates: Vec<Estimate>,
    /// Paths of each pixel, those that were left out too.
    pub samples: u64,
    /// Paths that were left out.
    pub bad: u64,
}

impl Film {
    /// An empty film of a given number of pixels.
    pub fn new(pixels: usize) -> Self {
        Self { estimates: vec![Estimate::default(); pixels], samples: 0, bad: 0 }
    }

    /// The rms of the standard errors of one band of `bands`, relative to the rms of its means; zero where all is dark.
    pub fn relative_error(&self, band: usize, bands: usize) -> f64 {
        let size = self.estimates.len() / bands;
        let estimates = &self.estimates[band * size..(band + 1) * size];
        let (errors, means) = estimates.iter().fold((0.0, 0.0), |(e, m), x| (e + x.error().powi(2), m + x.mean * x.mean));
        if errors == 0.0 { 0.0 } else { (errors / means).sqrt() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Means and standard errors are those of their definition: 1, 2, 3, 4 have mean 5/2 and error √(5/3 / 4).
    #[test]
    fn means_and_errors() {
        let mut estimate = Estimate::default();
        assert_eq!(estimate.error(), f64::INFINITY);
        [1.0, 2.0, 3.0, 4.0].into_iter().for_each(|v| estimate.add(v));
        assert!((estimate.mean - 2.5).abs() < 1e-15 && (estimate.error() - (5.0f64 / 12.0).sqrt()).abs() < 1e-15);
        let film = Film { estimates: vec![estimate; 6], samples: 4, bad: 0 };
        assert!((film.relative_error(1, 2) - (5.0f64 / 12.0).sqrt() / 2.5).abs() < 1e-15);
    }
}
