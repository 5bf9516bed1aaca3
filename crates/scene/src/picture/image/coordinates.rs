//! World coordinates of images that are placed on the sky.

use super::PixelScale;
use crate::observation::{Observation, SkyFrame};

/// World coordinates as FITS has them (Calabretta & Greisen 2002, A&A 395, 1077).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkyCoordinates {
    /// Reference frame of the coordinates.
    pub frame: SkyFrame,
    /// The projection, TAN, ARC or CAR.
    pub projection: &'static str,
    /// CDELT: longitude grows to the left.
    pub step_deg: [f64; 2],
    /// CRVAL: the target, or the place over the image's own pole.
    pub reference_deg: [f64; 2],
    /// Position and orientation of the image on the sky.
    pub turned: Turned,
}

/// How an image lies on the sky.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Turned {
    /// Its plane is turned: the matrix PC.
    Plane([[f64; 2]; 2]),
    /// Its own longitudes and latitudes are. CRVAL is where its own pole is, PV1_1 = 0 and PV1_2 = 90 say so: with CRVAL at the
    /// target two poles would fit, and readers choose between them by the last bits of LATPOLE.
    Sphere {
        /// LONPOLE, the image's own longitude of the sky's pole \[deg\].
        pole_deg: f64,
    },
}

impl SkyCoordinates {
    /// Those of an image of such pixels; none where one projection does not have them.
    pub fn of(observation: &Observation, pixel: PixelScale) -> Option<Self> {
        let (projection, step_deg) = match (pixel, observation.distance_pc) {
            (PixelScale::Angle(degrees), _) => ("TAN", degrees),
            // A length at a distance is the tangent of an angle.
            (PixelScale::Length(pc), Some(distance)) => ("TAN", (pc / distance).to_degrees()),
            (PixelScale::Equidistant(degrees), _) => ("ARC", degrees),
            (PixelScale::PlateCarree(degrees), _) => ("CAR", degrees),
            (PixelScale::Length(_), None) | (PixelScale::OnCube(_), _) => return None,
        };
        let target = [observation.target.longitude_deg, observation.target.latitude_deg];
        let (sin, cos) = observation.position_angle.sin_cos();
        let (reference_deg, turned) = match projection {
            "CAR" => {
                let (sin_latitude, cos_latitude) = target[1].to_radians().sin_cos();
                let beside = sin.atan2(-sin_latitude * cos).to_degrees();
                let height = (cos * cos_latitude).clamp(-1.0, 1.0).asin().to_degrees();
                let pole_deg = (-sin * cos_latitude).atan2(sin_latitude).to_degrees();
                ([(target[0] + beside).rem_euclid(360.0), height], Turned::Sphere { pole_deg })
            }
            _ => (target, Turned::Plane([[cos, -sin], [sin, cos]])),
        };
        Some(Self { frame: observation.target.frame, projection, step_deg: [-step_deg, step_deg], reference_deg, turned })
    }

    /// CTYPE of both axes.
    pub fn kinds(&self) -> [String; 2] {
        self.frame.axes().map(|axis| format!("{axis:-<4}-{}", self.projection))
    }
}

/// Solid angle of a pixel of a plane \[sr\]: Ω = p² cos³θ, p the edge of the pixel in the middle \[rad\], tan θ the distance from the axis
/// of view, which is `axis` to the right and upwards from the middle \[pixels\].
pub(crate) fn solid_angle(edge_rad: f64, [width, height]: [usize; 2], axis: (f64, f64), pixel: usize) -> f64 {
    let square = edge_rad * edge_rad;
    let (column, row) = ((pixel % width) as f64, (pixel / width) as f64);
    let right = column + 0.5 - 0.5 * width as f64 - axis.0;
    let up = 0.5 * height as f64 - row - 0.5 - axis.1;
    square * (1.0 + square * (right * right + up * up)).powf(-1.5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::SkyPlace;

    fn observation(target: SkyPlace, degrees: f64) -> Observation {
        Observation { target, position_angle: degrees.to_radians(), ..Observation::default() }
    }

    /// CTYPE is eight letters; north is up and east left unless the picture is turned, by a right angle east is down.
    #[test]
    fn images_lie_on_the_sky() {
        let target = SkyPlace { longitude_deg: 274.7, latitude_deg: -13.8, ..SkyPlace::default() };
        let coordinates = |degrees| SkyCoordinates::of(&observation(target, degrees), PixelScale::Angle(0.1)).unwrap();
        assert_eq!(coordinates(0.0).kinds(), ["RA---TAN", "DEC--TAN"]);
        let galactic = SkyPlace { frame: SkyFrame::Galactic, ..target };
        let all_around = SkyCoordinates::of(&observation(galactic, 0.0), PixelScale::PlateCarree(0.1)).unwrap();
        assert_eq!(all_around.kinds(), ["GLON-CAR", "GLAT-CAR"]);
        // The picture's own pole is 90 degrees above the target, beyond the sky's pole from here.
        assert!((all_around.reference_deg[0] - 274.7).abs() < 1e-9 && (all_around.reference_deg[1] - 76.2).abs() < 1e-9, "{all_around:?}");
        let Turned::Sphere { pole_deg } = all_around.turned else { panic!("{all_around:?}") };
        assert!((pole_deg.abs() - 180.0).abs() < 1e-9, "{pole_deg}");
        let east_and_north = |degrees, [x, y]: [f64; 2]| {
            let Turned::Plane(pc) = coordinates(degrees).turned else { panic!("no plane") };
            [0, 1].map(|i| (coordinates(degrees).step_deg[i] * (pc[i][0] * x + pc[i][1] * y) * 1e9).round() / 1e9)
        };
        assert_eq!((east_and_north(0.0, [1.0, 0.0]), east_and_north(0.0, [0.0, 1.0])), ([-0.1, 0.0], [0.0, 0.1]));
        assert_eq!((east_and_north(90.0, [0.0, 1.0]), east_and_north(90.0, [1.0, 0.0])), ([0.1, 0.0], [0.0, 0.1]));
    }

    /// A length at a distance is an angle; without one, and on a cube, there are no coordinates.
    #[test]
    fn lengths_become_angles() {
        let near = Observation::default();
        let far = Observation { distance_pc: Some(400.0), ..near };
        let step = SkyCoordinates::of(&far, PixelScale::Length(0.01)).unwrap().step_deg[1];
        assert!((step - (0.01f64 / 400.0).to_degrees()).abs() < 1e-15);
        assert!(SkyCoordinates::of(&near, PixelScale::Length(0.01)).is_none());
        assert!(SkyCoordinates::of(&near, PixelScale::OnCube(1.0)).is_none());
    }
}
