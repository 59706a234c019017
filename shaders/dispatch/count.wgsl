// Count: numbers of 64 bits in two slots of the status buffer.
// writes  status

fn count(low: u32, high: u32, n: u32) {
    let before = atomicAdd(&status[low], n);
    if before + n < before {
        atomicAdd(&status[high], 1u);
    }
}
