//! Places on the sky, as astronomers write them.

use crate::properties::Choices;
use glam::{DMat3, DVec3};

use crate::error::{Error, Result};

/// Reference frame of sky coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SkyFrame {
    /// Right ascension and declination, ICRS.
    #[default]
    Icrs,
    /// Galactic longitude and latitude.
    Galactic,
}

impl Choices for SkyFrame {
    const ROWS: &'static [(&'static str, Self)] = &[("icrs", Self::Icrs), ("galactic", Self::Galactic)];
}

impl SkyFrame {
    /// FITS names of its axes.
    pub fn axes(self) -> [&'static str; 2] {
        match self {
            Self::Icrs => ["RA", "DEC"],
            Self::Galactic => ["GLON", "GLAT"],
        }
    }

    /// Turns directions of ICRS into those of the frame (ESA 1997, SP-1200, The Hipparcos Catalogue, 1, 1.5.3).
    pub fn from_icrs(self) -> DMat3 {
        match self {
            Self::Icrs => DMat3::IDENTITY,
            Self::Galactic => DMat3::from_cols(
                DVec3::new(-0.054_875_560_416_215_4, 0.494_109_427_875_583_7, -0.867_666_149_019_004_7),
                DVec3::new(-0.873_437_090_234_885, -0.444_829_629_960_011_2, -0.198_076_373_431_201_5),
                DVec3::new(-0.483_835_015_548_713_2, 0.746_982_244_497_219, 0.455_983_776_175_066_9),
            ),
        }
    }

    /// FITS name of the frame, if the axes do not state it.
    pub fn reference(self) -> Option<&'static str> {
        (self == Self::Icrs).then_some("ICRS")
    }
}

/// A place on the sky.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SkyPlace {
    /// Reference frame of its coordinates.
    pub frame: SkyFrame,
    /// Right ascension, or Galactic longitude \[deg\].
    pub longitude_deg: f64,
    /// Declination, or Galactic latitude \[deg\].
    pub latitude_deg: f64,
}

/// Accepted forms of a position on the sky, for messages.
const EXAMPLE: &str = "two angles such as \"18h18m48s -13d49m00s\", \"18:18:48 -13:49:00\" or \"274.7 deg -13.8167 deg\"";

impl SkyPlace {
    /// The place that a text says: longitude and latitude, in hours (`18h18m48s`), in degrees (`-13d49m`, `274.7 deg`), or parted by
    /// colons: hours then of right ascension, degrees of anything else.
    ///
    /// # Errors
    /// If it says none.
    pub fn parse(frame: SkyFrame, text: &str) -> Result<Self> {
        let wrong = || Error::malformed("place on the sky", text, EXAMPLE);
        // A unit that stands behind a blank belongs to the number before.
        let mut parts: Vec<String> = Vec::new();
        for word in text.split([' ', '\t', ',']).filter(|word| !word.is_empty()) {
            match parts.last_mut() {
                Some(last) if word.starts_with(|c: char| c.is_ascii_alphabetic()) => *last += word,
                _ => parts.push(word.to_owned()),
            }
        }
        let [longitude, latitude] = parts.as_slice() else { return Err(wrong()) };
        let hours_by_colons = frame == SkyFrame::Icrs;
        let longitude_deg = degrees(longitude, hours_by_colons).ok_or_else(wrong)?;
        let latitude_deg = degrees(latitude, false).filter(|_| !latitude.contains('h')).ok_or_else(wrong)?;
        let place = Self { frame, longitude_deg, latitude_deg };
        place.check()?;
        Ok(Self { longitude_deg: longitude_deg.rem_euclid(360.0), ..place })
    }

    /// Its direction, and those of east and north there, each of length one, ICRS.
    pub fn axes(&self) -> [DVec3; 3] {
        let (sin_l, cos_l) = self.longitude_deg.to_radians().sin_cos();
        let (sin_b, cos_b) = self.latitude_deg.to_radians().sin_cos();
        let matrix_rows = [
            DVec3::new(cos_b * cos_l, cos_b * sin_l, sin_b),
            DVec3::new(-sin_l, cos_l, 0.0),
            DVec3::new(-sin_b * cos_l, -sin_b * sin_l, cos_b),
        ];
        matrix_rows.map(|axis| self.frame.from_icrs().transpose() * axis)
    }

    /// Its direction, of length one, ICRS: x to right ascension 0, z to the pole.
    pub fn direction(&self) -> DVec3 {
        self.axes()[0]
    }

    /// Refuses numbers that are no place.
    ///
    /// # Errors
    /// If a latitude is beyond the poles, or a longitude not within a turn.
    pub fn check(&self) -> Result<()> {
        if !(-360.0..=360.0).contains(&self.longitude_deg) || !(-90.0..=90.0).contains(&self.latitude_deg) {
            let value = format!("{} deg, {} deg", self.longitude_deg, self.latitude_deg);
            let allowed = "a longitude from 0 to 360 deg and a latitude from -90 to 90 deg";
            return Err(Error::out_of_range("place on the sky", value, allowed));
        }
        Ok(())
    }
}

/// The degrees that an angle says; without a unit, and where colons part it, it is in hours or in degrees.
fn degrees(text: &str, in_hours: bool) -> Option<f64> {
    let (sign, text) = match text.strip_prefix('-') {
        Some(rest) => (-1.0, rest),
        None => (1.0, text.strip_prefix('+').unwrap_or(text)),
    };
    if text.contains(':') {
        let parts: Vec<&str> = text.split(':').collect();
        return Some(sign * if in_hours { 15.0 } else { 1.0 } * sixtieths(&parts)?);
    }
    if let Some(number) = text.strip_suffix("deg") {
        return Some(sign * sixtieths(&[number])?);
    }
    let hours = text.contains('h');
    let (mut parts, mut rest) = (Vec::new(), text);
    for (i, unit) in [if hours { 'h' } else { 'd' }, 'm', 's'].into_iter().enumerate() {
        match rest.split_once(unit) {
            Some((number, behind)) => {
                parts.push(number);
                rest = behind;
            }
            None if i == 0 => return Some(sign * sixtieths(&[rest])?),
            None => break,
        }
    }
    rest.is_empty().then_some(())?;
    Some(sign * if hours { 15.0 } else { 1.0 } * sixtieths(&parts)?)
}

/// A number, its minutes and its seconds: each but the last whole, minutes and seconds below 60.
fn sixtieths(parts: &[&str]) -> Option<f64> {
    let mut sum = 0.0;
    for (i, part) in parts.iter().enumerate() {
        let value: f64 = part.parse().ok().filter(|value: &f64| value.is_finite())?;
        let is_digits = part.starts_with(|c: char| c.is_ascii_digit());
        let is_right = is_digits && (i == 0 || value < 60.0) && (i + 1 == parts.len() || value.fract() == 0.0);
        is_right.then_some(())?;
        sum += value / 60f64.powi(i as i32);
    }
    (1..=3).contains(&parts.len()).then_some(sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// M 16 in every way of writing it, to a thousandth of an arcsecond.
    #[test]
    fn places_are_read() {
        let (ra, dec) = (15.0 * (18.0 + 18.0 / 60.0 + 48.5 / 3600.0), -(13.0 + 49.0 / 60.0));
        for text in [
            "18h18m48.5s -13d49m",
            "18h18m48.5s -13d49m00s",
            "18:18:48.5 -13:49:00",
            "18:18:48.5, -13:49",
            "274.702083333333 -13.8166666666667",
            "274.702083333333 deg -13.8166666666667 deg",
            "274.702083333333d -13.8166666666667d",
            "-85.297916666667deg -13.8166666666667deg",
        ] {
            let place = SkyPlace::parse(SkyFrame::Icrs, text).unwrap();
            assert!((place.longitude_deg - ra).abs() < 1e-9 && (place.latitude_deg - dec).abs() < 1e-9, "{text}: {place:?}");
        }
        // Colons of a Galactic longitude part degrees; a latitude just below the equator keeps its sign.
        let place = SkyPlace::parse(SkyFrame::Galactic, "16:57:00 -0d30m").unwrap();
        assert_eq!((place.longitude_deg, place.latitude_deg), (16.95, -0.5));
    }

    /// The Galactic pole is at 12h51m26.28s +27d07m41.7s, the centre at 17h45m37.2s -28d56m10.2s (ESA 1997, SP-1200, 1, 1.5.3).
    #[test]
    fn galactic_places_are_places() {
        let galactic = |l: f64, b: f64| SkyPlace { frame: SkyFrame::Galactic, longitude_deg: l, latitude_deg: b }.direction();
        let icrs = |text: &str| SkyPlace::parse(SkyFrame::Icrs, text).unwrap().direction();
        for (place, text) in [(galactic(10.0, 90.0), "12h51m26.2752s 27d07m41.704s"), (galactic(0.0, 0.0), "17h45m37.1991s -28d56m10.221s")]
        {
            assert!((place - icrs(text)).length() < 1e-7, "{text}: {place}");
        }
        let turn = SkyFrame::Galactic.from_icrs();
        assert!((turn * turn.transpose() - DMat3::IDENTITY).abs_diff_eq(DMat3::ZERO, 1e-12));
        let [ahead, east, north] = SkyPlace { longitude_deg: 33.0, latitude_deg: -61.0, ..SkyPlace::default() }.axes();
        assert!((east.cross(north) - ahead).length() < 1e-12);
    }

    #[test]
    fn what_is_no_place_is_refused() {
        for text in [
            "",
            "18h18m48s",
            "18h18m48s -13d49m 7",
            "18h78m 3d",
            "12.5h30m 3d",
            "1h2m3x 4d",
            "nan 4",
            "10 95 deg",
            "400 3",
            "1:2:3:4 5",
            "--3 4",
            "10 1h",
            "inf 2",
        ] {
            let message = SkyPlace::parse(SkyFrame::Icrs, text).unwrap_err().to_string();
            assert!(message.contains("deg"), "{text}: {message}");
        }
    }
}
