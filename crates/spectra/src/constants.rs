//! Physical and astronomical constants, each with its source. Nowhere else.

/// Planck constant [J s] (CODATA 2018, exact).
pub const PLANCK: f64 = 6.626_070_15e-34;
/// Speed of light in vacuum [m s⁻¹] (CODATA 2018, exact).
pub const SPEED_OF_LIGHT: f64 = 299_792_458.0;
/// Boltzmann constant [J K⁻¹] (CODATA 2018, exact).
pub const BOLTZMANN: f64 = 1.380_649e-23;
/// Electronvolt \[J\] (CODATA 2018, exact).
pub const ELECTRONVOLT: f64 = 1.602_176_634e-19;
/// Stefan–Boltzmann constant [W m⁻² K⁻⁴] (CODATA 2018).
pub const STEFAN_BOLTZMANN: f64 = 5.670_374_419e-8;
/// Astronomical unit \[m\] (IAU 2012 resolution B2, exact).
pub const ASTRONOMICAL_UNIT: f64 = 149_597_870_700.0;
/// Parsec \[m\] (IAU 2015 resolution B2: 648000/π au).
pub const PARSEC: f64 = ASTRONOMICAL_UNIT * 648_000.0 / std::f64::consts::PI;
/// Julian year \[s\] (IAU: 365.25 days).
pub const JULIAN_YEAR: f64 = 365.25 * 86_400.0;
/// Light year \[m\] (IAU: a Julian year of light).
pub const LIGHT_YEAR: f64 = SPEED_OF_LIGHT * JULIAN_YEAR;
/// Nominal solar luminosity \[W\] (IAU 2015 resolution B3).
pub const SOLAR_LUMINOSITY: f64 = 3.828e26;
/// Nominal solar radius \[m\] (IAU 2015 resolution B3).
pub const SOLAR_RADIUS: f64 = 6.957e8;
/// Solar mass \[kg\] (IAU 2015 resolution B3: GM = 1.3271244e20 m³ s⁻²; G of CODATA 2018).
pub const SOLAR_MASS: f64 = 1.327_124_4e20 / 6.674_30e-11;
/// Atomic mass constant \[kg\] (CODATA 2018).
pub const ATOMIC_MASS: f64 = 1.660_539_066_60e-27;
/// Mass of a hydrogen atom \[kg\] (AME2020: 1.00782503190 u).
pub const HYDROGEN_MASS: f64 = 1.007_825_031_90 * ATOMIC_MASS;
/// Magnitudes of extinction in one unit of optical depth \[mag\]: 2.5 log₁₀ e, A = 1.0857 τ.
pub const MAGNITUDES_PER_DEPTH: f64 = 2.5 * std::f64::consts::LOG10_E;
/// AB zero point f_ν [W m⁻² Hz⁻¹] (Oke & Gunn 1983: 3631 Jy).
pub const AB_ZERO_POINT: f64 = 3631.0e-26;
/// The wavelength at which extinction curves are one \[µm\] (V band).
pub const V_WAVELENGTH_UM: f64 = 0.55;
/// 4π \[sr\]: the whole sphere.
pub const SPHERE: f64 = 4.0 * std::f64::consts::PI;
