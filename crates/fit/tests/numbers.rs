//! Fits of numbers whose answers are known.

use barnard::properties::Table;
use barnard::random::Counter;
use barnard::{Control, Result};
use barnard_fit::solve::{Fitted, Measured, Model, Prediction, fit};
use barnard_fit::{Parameter, free_parameters};

/// y = a e^(−x/t) + b + c x at 400 places; `knows` is what it says of its noise.
struct Decay {
    knows: Option<fn(f64) -> f64>,
    calls: usize,
}

const PLACES: usize = 400;

fn place(i: usize) -> f64 {
    10.0 * i as f64 / PLACES as f64
}

fn decay([a, t, b, c]: [f64; 4], x: f64) -> f64 {
    a * (-x / t).exp() + b + c * x
}

impl Model for Decay {
    fn predict(&mut self, values: &[f64], _: &Control) -> Result<Prediction> {
        self.calls += 1;
        let residual = |i: usize| decay([values[0], values[1], values[2], values.get(3).copied().unwrap_or(0.0)], place(i));
        let mean: Vec<f64> = (0..PLACES).map(residual).collect();
        let sigma = self.knows.map(|knows| mean.iter().map(|m| knows(*m)).collect());
        Ok(Prediction { mean, sigma })
    }

    fn floor(&mut self, values: &[f64], control: &Control) -> Result<Vec<f64>> {
        Ok(self.predict(values, control)?.mean.iter().map(|m| 1e-3 * m.abs()).collect())
    }
}

const TRUTH: [f64; 4] = [100.0, 2.5, 20.0, 0.0];

/// Two normal numbers.
fn normal(random: &mut Counter) -> f64 {
    let (u, v) = (random.uniform().max(1e-12), random.uniform());
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

fn drawn(seed: u64, sigma: impl Fn(f64) -> f64) -> Measured {
    let mut random = Counter::nested(seed, 0, 0);
    let value = |i: usize| {
        let mean = decay(TRUTH, place(i));
        mean + sigma(mean) * normal(&mut random)
    };
    Measured { values: (0..PLACES).map(value).collect(), sigma: vec![1.0; PLACES] }
}

fn free(text: &str) -> Vec<Parameter> {
    free_parameters(text, &Table::default()).unwrap()
}

fn fitted(data: &Measured, parameters: &[Parameter], start: &[f64], knows: Option<fn(f64) -> f64>) -> Result<Fitted> {
    fit(&mut Decay { knows, calls: 0 }, data, parameters, start, &Control::default())
}

/// Truth lies within two standard errors as often as it should, linear parameters are known for such, and the covariance is that of the
/// closed form.
#[test]
fn truth_is_within_the_errors() {
    let mut within = [0; 3];
    for seed in 0..300 {
        let found = fitted(&drawn(seed, |_| 1.0), &free("a, t, b"), &[50.0, 1.0, 0.0], None).unwrap();
        assert_eq!(found.linear, [true, false, true]);
        assert!(found.converged && found.degenerate.is_empty());
        for (i, within) in within.iter_mut().enumerate() {
            *within += usize::from((found.values[i] - TRUTH[i]).abs() < 2.0 * found.sigma_of(i));
        }
        if seed == 0 {
            let columns = |i: usize| {
                let (x, a, t) = (place(i), found.values[0], found.values[1]);
                let e = (-x / t).exp();
                [e, a * x / (t * t) * e, 1.0]
            };
            let normal = nalgebra::DMatrix::from_fn(3, 3, |a, b| (0..PLACES).map(|i| columns(i)[a] * columns(i)[b]).sum::<f64>());
            let covariance = normal.try_inverse().unwrap();
            for (a, b) in (0..3).flat_map(|a| (0..3).map(move |b| (a, b))) {
                let scale = (covariance[(a, a)] * covariance[(b, b)]).sqrt();
                assert!((found.covariance[(a, b)] - covariance[(a, b)]).abs() < 0.02 * scale, "{a} {b}");
            }
            // By how much parameters follow data that are off by a thousandth each, all to the worse side.
            for i in 0..3 {
                let pull = |d: usize| (0..3).map(|b| covariance[(i, b)] * columns(d)[b]).sum::<f64>();
                let mean = |d: usize| decay([found.values[0], found.values[1], found.values[2], 0.0], place(d));
                let wanted: f64 = (0..PLACES).map(|d| (pull(d) * 1e-3 * mean(d)).abs()).sum();
                assert!((found.floor[i] / wanted - 1.0).abs() < 0.01, "{i}: {} {wanted}", found.floor[i]);
            }
        }
    }
    // 95.4 of a hundred, of three hundred draws within four standard deviations.
    assert!(within.iter().all(|within| (271..=300).contains(within)), "{within:?}");
}

/// Noise of counts by the data's own numbers makes means too low; by the model's it does not. Noise that is larger than it is said to be is
/// seen in χ².
#[test]
fn noise_is_that_of_the_model() {
    let poisson: fn(f64) -> f64 = |mean| mean.max(0.0).sqrt();
    let (mut squares, mut by_data, mut chi2) = (0.0, 0.0, 0.0);
    const DRAWS: u64 = 200;
    for seed in 0..DRAWS {
        let mut data = drawn(seed, |mean| mean.sqrt());
        let found = fitted(&data, &free("a, t, b"), &[50.0, 1.0, 5.0], Some(poisson)).unwrap();
        squares += (found.values[2] - TRUTH[2]) / found.sigma_of(2) / DRAWS as f64;
        chi2 += found.chi2.0 / DRAWS as f64;
        data.sigma = data.values.iter().map(|value| value.max(1.0).sqrt()).collect();
        let found = fitted(&data, &free("a, t, b"), &[50.0, 1.0, 5.0], None).unwrap();
        by_data += (found.values[2] - TRUTH[2]) / found.sigma_of(2) / DRAWS as f64;
    }
    // The mean of 200 pulls is right to 0.07.
    assert!(squares.abs() < 0.3 && by_data < -1.0, "{squares} {by_data}");
    let degrees = PLACES as f64 - 3.0;
    let deviation = (2.0 * degrees / DRAWS as f64).sqrt();
    assert!((chi2 - degrees).abs() < 5.0 * deviation, "{chi2}");
    let louder = |seed| fitted(&drawn(seed, |mean| 1.1 * mean.sqrt()), &free("a, t, b"), &[50.0, 1.0, 5.0], Some(poisson)).unwrap().chi2.0;
    let louder = (0..DRAWS).map(louder).sum::<f64>() / DRAWS as f64;
    assert!(louder > degrees + 20.0 * deviation, "{louder}");
}

/// Bounds hold linear parameters and others; priors count as data do.
#[test]
fn bounds_and_priors_hold() {
    let data = drawn(1, |_| 1.0);
    let found = fitted(&data, &free("a, t, b=25..40"), &[50.0, 1.0, 30.0], None).unwrap();
    assert!(found.values[2] == 25.0 && found.bounded == [2], "{:?}", found.values);
    let found = fitted(&data, &free("a, t=0.1..2.0, b"), &[50.0, 1.0, 0.0], None).unwrap();
    assert!((1.9..=2.0).contains(&found.values[1]), "{:?}", found.values);
    let (plain, known) = (fitted(&data, &free("a, t, b"), &[50.0, 1.0, 0.0], None).unwrap(), free("a, t~2.6+-0.01, b"));
    let found = fitted(&data, &known, &[50.0, 1.0, 0.0], None).unwrap();
    // Two measurements of t, of which each counts by its error.
    let weight = |sigma: f64| 1.0 / (sigma * sigma);
    let both = (plain.values[1] * weight(plain.sigma_of(1)) + 2.6 * weight(0.01)) / (weight(plain.sigma_of(1)) + weight(0.01));
    assert!((found.values[1] - both).abs() < 0.3 * found.sigma_of(1) && found.sigma_of(1) < 0.01, "{} {both}", found.values[1]);
}

/// A model that ends somewhere is fitted up to there: steps beyond are shortened, slopes are taken from this side.
#[test]
fn models_may_end() {
    struct Ends(Decay, f64);
    impl Model for Ends {
        fn predict(&mut self, values: &[f64], control: &Control) -> Result<Prediction> {
            if values[1] > self.1 {
                return Err(barnard::error::Error::out_of_range("t", values[1], "smaller"));
            }
            self.0.predict(values, control)
        }
        fn floor(&mut self, values: &[f64], control: &Control) -> Result<Vec<f64>> {
            self.0.floor(values, control)
        }
    }
    let (data, free) = (drawn(3, |_| 1.0), free("a, t, b"));
    let run = |end: f64, start: f64| {
        fit(&mut Ends(Decay { knows: None, calls: 0 }, end), &data, &free, &[50.0, start, 0.0], &Control::default()).unwrap()
    };
    let whole = run(f64::INFINITY, 0.5);
    for (end, start) in [(whole.values[1] * 1.0001, 0.5), (2.8, 2.79)] {
        let found = run(end, start);
        assert!(found.converged, "{end}");
        assert!((0..3).all(|i| (found.values[i] - whole.values[i]).abs() < 0.02 * whole.sigma_of(i)), "{end}: {:?}", found.values);
        assert!((found.sigma_of(1) / whole.sigma_of(1) - 1.0).abs() < 0.05, "{end}");
    }
    // The best lies beyond: what is found is within.
    let found = run(2.0, 0.5);
    assert!(found.values[1] <= 2.0 && found.values[1] > 1.9, "{:?}", found.values);
}

/// Errors that are said a tenth of what they are, or ten times that, are seen in χ².
#[test]
fn wrong_errors_are_warned_of() {
    for (factor, words) in [(1.0, None), (0.1, Some("far above 1")), (10.0, Some("far below 1"))] {
        let mut data = drawn(5, |_| 1.0);
        data.sigma.iter_mut().for_each(|sigma| *sigma *= factor);
        let warning = fitted(&data, &free("a, t, b"), &[50.0, 1.0, 0.0], None).unwrap().chi2_warning();
        match (&warning, words) {
            (None, None) => {}
            (Some(warning), Some(words)) => assert!(warning.contains(words), "{warning}"),
            _ => panic!("{factor}: {warning:?}"),
        }
    }
}

/// What data cannot tell is said: parameters that do the same, those that do nothing, and values that are none.
#[test]
fn what_cannot_be_told_is_said() {
    struct Twice(Decay);
    impl Model for Twice {
        fn predict(&mut self, values: &[f64], control: &Control) -> Result<Prediction> {
            self.0.predict(&[values[0], 2.5, values[1] + values[2]], control)
        }
        fn floor(&mut self, values: &[f64], control: &Control) -> Result<Vec<f64>> {
            Ok(self.predict(values, control)?.mean)
        }
    }
    let data = drawn(2, |_| 1.0);
    let mut twice = Twice(Decay { knows: None, calls: 0 });
    let found = fit(&mut twice, &data, &free("a, b, c"), &[50.0, 5.0, 5.0], &Control::default()).unwrap();
    assert_eq!(found.degenerate, [1, 2]);
    assert!((found.values[1] + found.values[2] - 20.0).abs() < 1.0);
    struct Idle(Decay);
    impl Model for Idle {
        fn predict(&mut self, values: &[f64], control: &Control) -> Result<Prediction> {
            self.0.predict(&[values[0], 2.5, 20.0], control)
        }
        fn floor(&mut self, values: &[f64], control: &Control) -> Result<Vec<f64>> {
            Ok(self.predict(values, control)?.mean)
        }
    }
    let mut idle = Idle(Decay { knows: None, calls: 0 });
    let error = fit(&mut idle, &data, &free("a, star.0.x"), &[50.0, 5.0], &Control::default()).unwrap_err().to_string();
    assert!(error.contains("star.0.x") && error.contains("depend"), "{error}");
    let error = fitted(&data, &free("a=0..10, t, b"), &[50.0, 1.0, 0.0], None).unwrap_err().to_string();
    assert!(error.contains("the start value of a, 50,"), "{error}");
    let stopped = Control::default();
    stopped.interrupt();
    assert!(fit(&mut Decay { knows: None, calls: 0 }, &data, &free("a, t, b"), &[50.0, 1.0, 0.0], &stopped).is_err());
}

/// Of a light that is not there, in a picture of single precision beside a bright one, the error is that of the closed form.
#[test]
fn faint_lights_have_errors() {
    struct Faint;
    impl Model for Faint {
        fn predict(&mut self, values: &[f64], _: &Control) -> Result<Prediction> {
            if values[0] < 0.0 {
                return Err(barnard::error::Error::out_of_range("light", values[0], "at least zero"));
            }
            let signal = |i: usize| f64::from((values[0] * (-place(i)).exp() + values[1]) as f32);
            Ok(Prediction { mean: (0..PLACES).map(signal).collect(), sigma: None })
        }
        fn floor(&mut self, _: &[f64], _: &Control) -> Result<Vec<f64>> {
            Ok(vec![0.0; PLACES])
        }
    }
    let mut random = Counter::nested(5, 0, 0);
    // What noise takes away from the light that is not there.
    let value = |i: usize| 1e5 + normal(&mut random) - 0.5 * (-place(i)).exp();
    let data = Measured { values: (0..PLACES).map(value).collect(), sigma: vec![1.0; PLACES] };
    let found = fit(&mut Faint, &data, &free("light, sky"), &[5e4, 3e4], &Control::default()).unwrap();
    assert!(found.values[0] == 0.0 && found.bounded == [0] && found.linear == [true, true], "{:?}", found.values);
    let sums = |a: fn(f64) -> f64| (0..PLACES).map(|i| a(place(i))).sum::<f64>();
    let (ee, e, one) = (sums(|x| (-2.0 * x).exp()), sums(|x| (-x).exp()), PLACES as f64);
    let wanted = (one / (ee * one - e * e)).sqrt();
    assert!((found.sigma_of(0) / wanted - 1.0).abs() < 0.02, "{} {wanted}", found.sigma_of(0));
}
