// Workgroups in another order. Software renderers give each processor one range of a dispatch, half of it where there
// are two, and wait for the last: lists whose work lies at one end (the sea at the bottom of a picture, coasts, fine
// cells) keep the others idle. Here every range gets groups from all over, and neighbours stay within a few groups of
// one another.

// 0..count - 1, each once.
uint spread(uint id, uint count) {
    const uint WAYS = 8u;
    uint each = count / WAYS, longer = count % WAYS, split = longer * (each + 1u);
    bool first = id < split;
    uint from = first ? id : id - split, row = max(first ? each + 1u : each, 1u);
    uint way = uint((float(from) + 0.5) / float(row));   // integers divide slowly, and up to 2^20 this is exact
    return (from - way * row) * WAYS + way + (first ? 0u : longer);
}

uint spread_group() {
    return spread(gl_WorkGroupID.x, gl_NumWorkGroups.x);
}

// The same by runs of groups that stay together, because neighbours share much memory.
uint spread_blocks(uint each) {
    uint blocks = gl_NumWorkGroups.x / each, block = gl_WorkGroupID.x / each;
    return block < blocks ? spread(block, blocks) * each + gl_WorkGroupID.x % each : gl_WorkGroupID.x;
}

// For tiles of the picture.
uint spread_tiles() {
    return spread_blocks(32u);
}
