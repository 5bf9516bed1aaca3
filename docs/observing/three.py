"""A planetary nebula as three instruments record it: python docs/observing/three.py writes their masters, FITS and PNG."""

import barnard as bn

#: Name, passbands and palette, field of view [arcsec], pixels of the picture, and the instrument.
INSTRUMENTS = [
    ("hubble", "hst-wfc3-sho", "sho", 90, 2250, bn.Instrument(preset="hst-wfc3-uvis")),
    ("one_metre", "sho-3nm", "sho", 150, 800, bn.Instrument(preset="lco-1m-sinistro", exposure="600 s", frames=6)),
    ("amateur", "hoo-3nm", "hoo", 150, 620, bn.Instrument(preset="refractor-0.2m-duo")),
]

scene = bn.Scene.builtin("ring_nebula")
scene.observation = bn.Observation("18h53m35.1s 33d01m45s")
for name, bands, palette, field, size, instrument in INSTRUMENTS:
    scene.bands = bands
    scene.display = bn.Display(palette=palette, balance=True, stretch="asinh", strength=8)
    scene.camera = bn.PerspectiveCamera("0 0 790 pc", f"{field} arcsec", size=size)
    master = scene.render(progress=True).observe(instrument).master(progress=True)
    for extension in ("fits", "png"):
        master.write(f"{name}.{extension}")
