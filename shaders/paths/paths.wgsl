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
    return ((states_wanted(specular) >> state) & 1u) != 0u;
}

// The states, as a mask, from which a path that then meets so many specular surfaces and the eye is wanted.
fn states_wanted(specular: u32) -> u32 {
    let i = min(specular, 63u);
    return path_filter.accept[i >> 2u][i & 3u];
}

// The states, as a mask, from which `event` leads to one of these. Bit 31 is the dead state's: never set.
fn states_before(mask: u32, event: u32) -> u32 {
    var before = 0u;
    for (var state = 0u; state < 31u; state += 1u) {
        before |= ((mask >> path_step(state, event)) & 1u) << state;
    }
    return before;
}
