// What lights are asked for.

// Where a joton starts.
struct Start {
    origin: vec3<f32>,
    direction: vec3<f32>,
    flux: Bands,
}

// Where a shadow ray goes.
struct LightSample {
    // Unit, toward the light.
    wi: vec3<f32>,
    distance: f32,
    // Where a shadow ray ends: lifted off the light, so that it does not shade itself.
    end: vec3<f32>,
    // Irradiance across the beam over the probability of this sample.
    weight: Bands,
    // pdf_solid_angle with the pick; 0 where no BSDF sample can find the emitter.
    pdf: f32,
}
