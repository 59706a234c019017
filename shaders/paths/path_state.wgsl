// Bits of PathState.status; the state of the path automaton lies below, the number of events above.
const LANE_ALIVE: u32 = 32u;
const LANE_MET_SPECULAR: u32 = 64u;
const LANE_MET_DIFFUSE: u32 = 128u;
const LANE_DONE: u32 = 256u;
const LANE_CUT: u32 = 512u;
const LANE_EVENT: u32 = 0x10000u;
