use super::*;

/// A triangle of height 0.8 from 500 to 600 nm, its first column in another unit.
fn triangle(head: &str, per_nm: f64) -> String {
    let row = |nm: f64, t: f64| format!("{},{t}\n", nm * per_nm);
    format!("{head}{}{}{}", row(500.0, 0.0), row(550.0, 0.8), row(600.0, 0.0))
}

fn read(text: &str) -> Result<SpectralCurve> {
    SpectralCurve::parse("t.csv", text, CurveOptions::of_file(Ordinate::Throughput))
}

fn area_um(curve: &SpectralCurve) -> f64 {
    let (x, y) = (curve.table.x(), curve.table.y());
    (1..x.len()).map(|i| 0.5 * (x[i] - x[i - 1]) * (y[i] + y[i - 1])).sum()
}

/// The triangle's area is 0.04 µm, whatever its unit is and however it is written.
#[test]
fn stated_units_are_understood() {
    for (head, per_nm) in [
        ("lambda(A),t\n", 10.0),
        ("wave_ang,t\n", 10.0),
        ("Wavelength in A,t\n", 10.0),
        ("Angstroem,t\n", 10.0),
        ("wavelength Ångström,t\n", 10.0),
        ("wave[A],t\n", 10.0),
        ("lambda(m),t\n", 1e-9),
        ("Micrometers,t\n", 1e-3),
        ("mu,t\n", 1e-3),
        ("lambda(µ),t\n", 1e-3),
        ("lam_A,t\n", 10.0),
        ("WAVE_A,t\n", 10.0),
        ("Ang,t\n", 10.0),
        ("wl/A,t\n", 10.0),
        ("0.1 nm,t\n", 10.0),
        ("wave(1e-10 m),t\n", 10.0),
        ("mic,t\n", 1e-3),
        ("wave_m,t\n", 1e-9),
        ("metre,t\n", 1e-9),
        ("wavelength_nm,t\n", 1.0),
        ("Wavelength (NM),T\n", 1.0),
        ("# wavelength [um], t\n", 1e-3),
        ("#lambda_A,t\n", 10.0),
        ("# columns: wavelength_um, throughput\n", 1e-3),
        ("# column 1: Wavelength [Å]\n", 10.0),
        ("# wavelength unit: Angstrom\n", 10.0),
        ("wavelength,t\nAngstrom,\n", 10.0),
        ("wavelengthNm,t\n", 1.0),
        ("λ [µm],t\n", 1e-3),
        ("\u{feff}wave[A],t\n", 10.0),
        ("# central wavelength 5500 Angstrom, width 1000 Angstrom\nwavelength_um,T\n", 1e-3),
        ("# 1 WAVELENGTH   wavelength of the filter   [Angstrom]\n# 2 THROUGHPUT\n", 10.0),
        ("Wellenlaenge [nm],t\n", 1.0),
        ("# measured at 3 um, cold\nwave_nm,t\n", 1.0),
    ] {
        let curve = read(&triangle(head, per_nm)).unwrap_or_else(|e| panic!("{head:?}: {e}"));
        assert!((area_um(&curve) / 0.04 - 1.0).abs() < 1e-12 && !curve.is_inferred, "{head:?}: {}", curve.note);
    }
}

/// Without a unit, the range decides if it allows only one unit, and a note states it.
#[test]
fn missing_units_are_inferred_or_refused() {
    for (head, per_nm) in [("", 1.0), ("a,b\n", 1.0), ("# a filter, made at 550 nm\n", 1.0), ("", 1e-3), ("wavelength,t\n", 1.0)] {
        let curve = read(&triangle(head, per_nm)).unwrap_or_else(|e| panic!("{head:?}: {e}"));
        assert!((area_um(&curve) / 0.04 - 1.0).abs() < 1e-12 && curve.is_inferred && curve.note.contains("inferred"), "{head:?}");
    }
    for (head, per_nm, words) in [
        ("", 10.0, "angstrom or nm"),
        ("", 0.1, "in none"),
        ("frequency_Hz,t\n", 1.0, "corresponds to wavelengths"),
        ("", 1e-9, "in none"),
        ("lambda [furlong],t\n", 1.0, "furlong"),
        ("wavelength_furlong,t\n", 1.0, "furlong"),
        ("wavelength [nm vac],t\n", 1.0, "nm vac"),
        ("frequency_Hz,t\n", -1.0, "must be above zero"),
        ("frequency,t\n", 1.0, "frequency"),
        ("frequency_nm,t\n", 1.0, "frequency"),
        ("# Wavelengths are in Angstrom\n", 1.0, "line 1"),
        ("wave_nm [A],t\n", 1.0, "nm"),
        ("lambda (M),t\n", 1.0, "unknown unit"),
        ("# wavelength_nm, t\nwavelength_A,t\n", 1.0, "both"),
    ] {
        let error = read(&triangle(head, per_nm)).map(|curve| curve.note).unwrap_err().to_string();
        assert!(error.contains(words) && error.starts_with("t.csv: "), "{head:?}: {error}");
    }
}

#[test]
fn keys_state_unit_and_column() {
    let options = |unit, column| CurveOptions { ordinate: Ordinate::Throughput, unit, column };
    let svo = SpectralCurve::parse("t", &triangle("", 10.0), options(Some("Å"), None)).unwrap();
    assert!((area_um(&svo) / 0.04 - 1.0).abs() < 1e-12 && !svo.is_inferred);
    let wrong = |head: &str, unit| SpectralCurve::parse("t", &triangle(head, 1.0), options(Some(unit), None)).unwrap_err().to_string();
    assert!(wrong("wave_nm,t\n", "um").contains("has nm"));
    assert!(wrong("", "furlong").contains("furlong"));
    let three = "nm,id,filter_a,filter_b\n500,1,0.1,0.2\n600,1,0.3,0.4\n";
    let parsed = |column| SpectralCurve::parse("t", three, options(None, column));
    assert!(parsed(None).unwrap_err().to_string().contains("filter_a"));
    assert_eq!(parsed(Some("filter_b")).unwrap().table.y(), [0.2, 0.4]);
    assert_eq!(parsed(Some("3")).unwrap().table.y(), [0.1, 0.3]);
    assert!(parsed(Some("1")).is_err() && parsed(Some("x")).is_err() && parsed(Some("9")).is_err());
    let marked = SpectralCurve::parse("t", "nm,error,throughput\n500,9,0.1\n600,9,0.3\n", options(None, None)).unwrap();
    assert_eq!(marked.table.y(), [0.1, 0.3]);
}

/// Wavenumbers and frequencies are converted: the ends are 1e7/ν̃ nm and c/ν.
#[test]
fn other_axes_are_converted() {
    let curve = read("wavenumber [cm-1],T [%]\n16666.6666666667,20\n20000,40\n").unwrap();
    assert!((curve.table.x()[0] - 0.5).abs() < 1e-12 && (curve.table.x()[1] - 0.6).abs() < 1e-12);
    assert_eq!(curve.table.y(), [0.4, 0.2]);
    assert_eq!(read("# nm, T [%]\n500 0\n550 0.8\n600 0\n").unwrap().table.y(), [0.0, 0.008, 0.0]);
    let curve = read("frequency (THz),t\n500,0.5\n600,0.8\n").unwrap();
    assert!((curve.table.x()[0] - 299.792_458 / 600.0).abs() < 1e-12 && curve.table.y()[0] == 0.8);
    let air = read("wavelength_air [nm],t\n486.135,1\n656.279,0.5\n").unwrap();
    assert!((air.table.x()[1] - 0.656_461).abs() < 1.5e-6 && air.note.contains("air"));
}

#[test]
fn rows_are_ordered_and_finite() {
    let down = read("nm,t\n600,0.1\n500,0.2\n").unwrap();
    assert_eq!((down.table.x(), down.table.y()), (&[0.5, 0.6][..], &[0.2, 0.1][..]));
    for (text, words) in [
        ("nm,t\n500,1\n500,0.5\n", "line 3 repeats"),
        ("nm,t\n500,1\n600,0.5\n550,0.2\n", "line 4 is out of order"),
        ("nm,t\n-500,1\n600,0.5\n", "line 2"),
        ("nm,t\n500,\n600,1\n", "line 2"),
        ("nm,t\n500,inf\n600,1\n", "line 2"),
        ("nm,t [Jy]\n500,1\n600,1\n", "Jy"),
        ("nm,t\n500,1\n", "two rows"),
    ] {
        let error = read(text).unwrap_err().to_string();
        assert!(error.contains(words), "{text:?}: {error}");
    }
}

/// A flux that is flat in F_ν falls by (500/600)² in F_λ.
#[test]
fn fluxes_per_frequency_are_converted() {
    let parsed = |head: &str| SpectralCurve::parse("t", &format!("{head}\n500,1\n600,1\n"), CurveOptions::of_file(Ordinate::FluxDensity));
    let ratio = |head: &str| parsed(head).map(|curve| curve.table.y()[1] / curve.table.y()[0]);
    assert!((ratio("nm,flux [Jy]").unwrap() - (5.0f64 / 6.0).powi(2)).abs() < 1e-12);
    assert!((ratio("nm,flux [PHOTLAM]").unwrap() - 5.0 / 6.0).abs() < 1e-12);
    assert_eq!(ratio("nm,flux [erg/s/cm2/A]").unwrap(), 1.0);
    assert_eq!(ratio("nm,flux").unwrap(), 1.0);
    assert!((ratio("# wavelength [nm], flux [erg/s/cm2/Hz]").unwrap() - (5.0f64 / 6.0).powi(2)).abs() < 1e-12);
    assert!((ratio("wavelength_nm,f_nu").unwrap() - (5.0f64 / 6.0).powi(2)).abs() < 1e-12);
    assert!((ratio("wavelength_nm,lambda*F_lambda").unwrap() - 5.0 / 6.0).abs() < 1e-12);
    for head in ["nm,flux [abmag]", "wavelength_nm,AB mag"] {
        assert!(ratio(head).is_err(), "{head}");
    }
}
