// The automaton of --paths: which light paths are wanted.
// reads  path_filter

const EVENT_D: u32 = 0u;
const EVENT_S: u32 = 1u;

fn path_step(state: u32, event: u32) -> u32 {
    let i = 2u * state + event;
    return path_filter.transitions[i >> 2u][i & 3u];
}

// True where a path in `state`, then `specular` events and the eye, is wanted.
fn path_wanted(state: u32, specular: u32) -> bool {
    let i = min(specular, 63u);
    return ((path_filter.accept[i >> 2u][i & 3u] >> state) & 1u) != 0u;
}
