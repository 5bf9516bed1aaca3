"""A nebula that three instruments record, and what is found of it: python docs/observing/fitted.py writes masters, residuals and a table."""

import barnard as bn

FREE = """star.0.luminosity, star.0.temperature=8000..40000, star.1.luminosity, emission.0.scale, background.radiance, dust.scale=0.5..6"""
#: What the images are made of, and where the fit begins.
TRUTH = {"star.0.luminosity": 900, "star.0.temperature": 16000, "star.1.luminosity": 500, "emission.0.scale": 4e-25, "background.radiance": 3e-8, "dust.scale": 2.5}
BEGIN = {"star.0.luminosity": 300, "star.0.temperature": 25000, "star.1.luminosity": 1500, "emission.0.scale": 1e-24, "background.radiance": 1e-8, "dust.scale": 1.5}
#: Name, passbands, field of view [arcsec], pixels along a row, instrument.
INSTRUMENTS = [
    ("hubble", ["hst-wfc3-f438w", "hst-wfc3-f555w", "hst-wfc3-f814w"], 45, 256, bn.Instrument(preset="hst-wfc3-uvis", pixel_scale="0.2 arcsec", exposure="40 s", frames=4)),
    ("one_metre", "johnson", 140, 256, bn.Instrument(preset="lco-1m-sinistro", pixel_scale="0.7 arcsec", exposure="60 s", frames=6)),
    ("rubin", ["lsst2023-g", "lsst2023-r", "lsst2023-i"], 100, 256, bn.Instrument(preset="rubin-lsstcam", pixel_scale="0.5 arcsec", exposure="3 s", frames=2)),
]


def scene(values):
    """A cloud with two young stars in it, gas that glows, and light behind, at 2 kpc."""
    own = bn.Scene(bands="johnson", name="nebula", method=bn.Method(bake=96))
    own.camera = bn.perspective("0 0 2000 pc", "140 arcsec", size=256)
    own.fields["cloud"] = bn.Turbulence(seed=5, low="-0.6 -0.6 -0.6 pc", high="0.6 0.6 0.6 pc", voxels=96, outer_scale="0.5 pc", mach=3)
    own.fields["ball"] = bn.Plummer(core="0.2 pc", cut="0.55 pc")
    own.dust = bn.Dust("cloud * ball", f"{values['dust.scale']} /pc", law="gordon23", albedo=0.6)
    places = ["0.1 0.05 0.2 pc", "-0.2 -0.1 0.15 pc"]
    temperatures = [values["star.0.temperature"], 20000]
    for i, (place, temperature) in enumerate(zip(places, temperatures)):
        luminosity = values[f"star.{i}.luminosity"]
        own.stars.append(bn.Star(place, temperature=f"{temperature} K", luminosity=f"{luminosity} Lsun", visible=False))
    lines = [{"wavelength": "500.7 nm", "strength": 1}, {"wavelength": "656.3 nm", "strength": 1.5}]
    own.emission.append(bn.Emission(kind="lines", density="cloud * ball", scale=f"{values['emission.0.scale']} W/m3/sr", lines=lines))
    own.background = bn.Background(kind="blackbody", temperature="4500 K", radiance=f"{values['background.radiance']} W/m2/sr/um")
    return own


images = []
for name, bands, field, size, instrument in INSTRUMENTS:
    parts = {"bands": bands, "camera": bn.perspective("0 0 2000 pc", f"{field} arcsec", size=size), "instrument": instrument}
    truth = scene(TRUTH)
    for key, value in parts.items():
        setattr(truth, key, value)
    master = truth.render().observe().master()
    master.write(f"{name}.fits")
    master.write(f"{name}.png")
    images.append((f"{name}.fits", parts))
fit = scene(BEGIN).fit(FREE, images, progress=True)
print(fit)
for key, value in fit.values.items():
    print(f"| `{key}` | {TRUTH[key]:g} | {BEGIN[key]:g} | {value:.5g} ± {fit.sigma[key]:.2g} {fit.units[key]} | {(value - TRUTH[key]) / fit.sigma[key]:+.1f} |")
