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

// The points of a sequence that light samples take: the first one, and whose sequence it is.
struct LightDraws {
    first: vec2<u32>,
    path: u32,
    stream: u32,
}

// What light samples find in lobes that are followed [E46].
struct FollowedLight {
    // Without the throughput, with its share of the weight.
    light: Bands,
    rays: u32,
    saved: u32,
}
