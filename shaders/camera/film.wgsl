// Film: what a pixel sees goes to the film as linear red, green and blue [E34].
// import: scene/features.wgsl
// reads  pass_info

fn to_film(b: Bands) -> vec4<f32> {
    if !HAS_WAVELENGTHS {
        return four_of_bands(b);
    }
    // the bands of this pass, each with its colour
    return vec4(
        dot(b, bands_of_four(pass_info.red)), dot(b, bands_of_four(pass_info.green)), dot(b, bands_of_four(pass_info.blue)),
        0.0,
    );
}
