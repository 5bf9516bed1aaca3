//! Astronomy Visualization Metadata: where on the sky a picture for eyes is, as planetaria and PyAVM read it.
//!
//! An XMP packet. Source: AVM standard 1.2 (Hurt, Christensen & Gauthier 2011); pixels are counted as in FITS, from the lower left.

use barnard::image::{Image, SkyCoordinates, Turned};
use barnard::observation::SkyFrame;

/// The keyword of a PNG's text that is an XMP packet.
pub const XMP: &str = "XML:com.adobe.xmp";

/// The packet of a picture that lies on the sky in one plane; none of others.
pub fn packet(image: &Image) -> Option<String> {
    let sky = SkyCoordinates::of(image.observation.as_ref()?, image.pixel?)?;
    let Turned::Plane([[cos, _], [sin, _]]) = sky.turned else { return None };
    // At the pole LONPOLE is zero by default, and AVM cannot state it: the picture is rotated by its effect.
    let beyond = if sky.reference_deg[1] == 90.0 { 180.0 } else { 0.0 };
    let pair = |name: &str, [a, b]: [f64; 2]| {
        format!("<avm:Spatial.{name}><rdf:Seq><rdf:li>{a}</rdf:li><rdf:li>{b}</rdf:li></rdf:Seq></avm:Spatial.{name}>\n")
    };
    let one = |name: &str, value: &str| format!("<avm:Spatial.{name}>{value}</avm:Spatial.{name}>\n");
    let frame = match sky.frame {
        SkyFrame::Icrs => "ICRS",
        SkyFrame::Galactic => "GAL",
    };
    let spatial = [
        one("CoordinateFrame", frame),
        one("CoordsystemProjection", sky.projection),
        pair("ReferenceValue", sky.reference_deg),
        pair("ReferenceDimension", [image.width as f64, image.height as f64]),
        pair("ReferencePixel", image.reference_pixel()),
        pair("Scale", sky.step_deg),
        // CROTA2 turns the other way where longitude grows to the left.
        one("Rotation", &format!("{}", beyond - sin.atan2(cos).to_degrees())),
        one("Quality", "Full"),
    ];
    let title = image.notes.iter().find(|(key, _)| key == "scene").map_or("", |(_, name)| name);
    Some(format!(
        "<?xpacket begin=\"\u{feff}\" id=\"W5M0MpCehiHzreSzNTczkc9d\"?>\n<x:xmpmeta xmlns:x=\"adobe:ns:meta/\">\n\
         <rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">\n<rdf:Description rdf:about=\"\" \
         xmlns:avm=\"http://www.communicatingastronomy.org/avm/1.0/\" xmlns:dc=\"http://purl.org/dc/elements/1.1/\">\n\
         <dc:title><rdf:Alt><rdf:li xml:lang=\"x-default\">{}</rdf:li></rdf:Alt></dc:title>\n\
         <avm:MetadataVersion>1.2</avm:MetadataVersion>\n{}</rdf:Description>\n</rdf:RDF>\n</x:xmpmeta>\n<?xpacket end=\"w\"?>",
        escaped(title),
        spatial.concat()
    ))
}

/// A text as XML holds it, without what it cannot hold.
fn escaped(text: &str) -> String {
    let text: String = text.chars().filter(|c| !c.is_control()).collect();
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use barnard::image::{PixelScale, Samples};
    use barnard::observation::{Observation, SkyPlace};

    use super::*;

    #[test]
    fn names_cannot_end_the_packet() {
        let target = SkyPlace { longitude_deg: 10.0, latitude_deg: 20.0, ..SkyPlace::default() };
        let observation = Observation { target, position_angle: 30f64.to_radians(), ..Observation::default() };
        let notes = vec![("scene".to_owned(), "</dc:title> & \u{1}more".to_owned())];
        let bare = Image::bare(4, 2, vec!["V".into()], Samples::Double(vec![0.0; 8]));
        let image = Image { observation: Some(observation), pixel: Some(PixelScale::Angle(0.5)), notes, ..bare };
        let packet = packet(&image).unwrap();
        assert!(packet.contains("&lt;/dc:title&gt; &amp; more") && packet.contains("<rdf:li>2.5</rdf:li><rdf:li>1.5</rdf:li>"), "{packet}");
        assert!(super::packet(&Image { pixel: Some(PixelScale::PlateCarree(0.5)), ..image }).is_none());
    }
}
