// SPDX-License-Identifier: Apache-2.0
// Eight slabs of cells along a ray at once, included once for each kind of Lanes (slab_walk.h).

/// The low corner of the voxels of cell i of an axis: cells 0 and n share those of their
/// neighbours, and positions in them are clamped.
BRUME_KERNEL inline Doubles lowCorner(const SlabRay& ray, std::size_t axis, const Doubles& cell) {
  return min(max(cell - Doubles::all(1), Doubles::all(0)), Doubles::all(ray.lastCorner[axis]));
}

/// Where the ray is in the slabs from `firstSlab` on. Stretches outside of its range have no
/// length.
BRUME_KERNEL inline void locate(const SlabRay& ray, std::int64_t firstSlab, SlabStretches& s) {
  static constexpr double kLaneIndex[kLanes] = {0, 1, 2, 3, 4, 5, 6, 7};
  const Doubles zero = Doubles::all(0), one = Doubles::all(1), range = Doubles::all(ray.length);
  const std::size_t major = ray.major;

  // Where the ray enters the slabs and leaves them.
  const Doubles step = Doubles::all(ray.step[major]), origin = Doubles::all(ray.o[major]),
                inverse = Doubles::all(ray.inverse);
  const Doubles slab = Doubles::all(double(firstSlab)) + step * Doubles::load(kLaneIndex);
  const Doubles plane = slab + Doubles::all(ray.step[major] > 0 ? 0.0 : 1.0);
  const Doubles start = min(max((plane - origin) * inverse, zero), range),
                end = min(max((plane + step - origin) * inverse, zero), range);
  const Doubles length = end - start;
  start.store(s.start.data());
  end.store(s.end.data());

  const Doubles majorCorner = lowCorner(ray, major, slab);
  const Lanes position =
      narrow(origin + start * Doubles::all(ray.d[major]) - (majorCorner + one));
  for (auto& cell : s.position) position.store(cell[major].data());
  narrow(length * Doubles::all(ray.d[major])).store(s.change[major].data());

  // The cell on either other axis, and where the ray leaves it for the next.
  Doubles index = majorCorner * Doubles::all(ray.stride[major]), indexShift[2];
  Lanes crossing[2], minor[2], shift[2];
  for (std::size_t i = 0; i < 2; ++i) {
    const std::size_t axis = ray.minor[i];
    const Doubles place = Doubles::all(ray.o[axis]) + start * Doubles::all(ray.d[axis]);
    const Doubles cell = min(max(floor(place), zero), Doubles::all(ray.lastCell[axis]));
    const Doubles corner = lowCorner(ray, axis, cell),
                  moved = lowCorner(ray, axis, cell + Doubles::all(ray.step[axis])) - corner;
    index = index + corner * Doubles::all(ray.stride[axis]);
    indexShift[i] = moved * Doubles::all(ray.stride[axis]);
    shift[i] = narrow(moved);
    minor[i] = narrow(place - (corner + one));
    const Lanes change = narrow(length * Doubles::all(ray.d[axis]));
    change.store(s.change[axis].data());
    const Lanes way = Lanes::all(ray.edge[axis]) - narrow(place - cell);
    crossing[i] = min(max(way / change, Lanes::all(0)), Lanes::all(1));
  }
  const Lanes firstCut = min(crossing[0], crossing[1]), lastCut = max(crossing[0], crossing[1]);
  firstCut.store(s.cut[0].data());
  lastCut.store(s.cut[1].data());
  s.isUsed = {less(Lanes::all(0), firstCut), less(firstCut, lastCut),
              less(lastCut, Lanes::all(1))};

  // The second cell lies across the edge that is met first, the third across both.
  const Lanes isFirst = lessMask(crossing[0], crossing[1]);
  const Lanes isFirstOne = Lanes::all(1) & isFirst;
  const Doubles firstOne = widen(isFirstOne), secondOne = one - firstOne;
  const std::size_t a = ray.minor[0], b = ray.minor[1];
  minor[0].store(s.position[0][a].data());
  minor[1].store(s.position[0][b].data());
  (minor[0] - shift[0] * isFirstOne).store(s.position[1][a].data());
  (minor[1] - shift[1] * (Lanes::all(1) - isFirstOne)).store(s.position[1][b].data());
  (minor[0] - shift[0]).store(s.position[2][a].data());
  (minor[1] - shift[1]).store(s.position[2][b].data());
  storeIndices(index, s.index[0].data());
  storeIndices(index + firstOne * indexShift[0] + secondOne * indexShift[1], s.index[1].data());
  storeIndices(index + indexShift[0] + indexShift[1], s.index[2].data());
}

/// The voxels around one of the cells of each stretch; bit 0: x, bit 1: y, bit 2: z.
BRUME_KERNEL inline void loadVoxels(const SlabRay& ray, const SlabStretches& s, std::size_t cell,
                                    Lanes (&voxels)[8]) {
  for (std::size_t row = 0; row < 4; ++row) {
    const LanePairs pairs = gatherPairs(ray.rows[row], s.index[cell].data());
    voxels[2 * row] = pairs.low;
    voxels[2 * row + 1] = pairs.high;
  }
}

BRUME_KERNEL inline Lanes mixed(const Lanes& a, const Lanes& b, const Lanes& f) {
  return (Lanes::all(1) - f) * a + f * b;
}

/// Position between the voxels of a cell, on one axis, at the fraction u of the stretches.
BRUME_KERNEL inline Lanes between(const SlabRay& ray, const SlabStretches& s, std::size_t cell,
                                  std::size_t axis, const Lanes& u) {
  const Lanes place = Lanes::load(s.position[cell][axis].data()) +
                      u * Lanes::load(s.change[axis].data());
  return min(max(place, Lanes::all(0)), Lanes::all(ray.widest[axis]));
}

BRUME_KERNEL inline Lanes densityAt(const SlabRay& ray, const SlabStretches& s, std::size_t cell,
                                    const Lanes (&v)[8], const Lanes& u) {
  const Lanes x = between(ray, s, cell, 0, u), y = between(ray, s, cell, 1, u),
              z = between(ray, s, cell, 2, u);
  const Lanes low = mixed(mixed(v[0], v[1], x), mixed(v[2], v[3], x), y),
              high = mixed(mixed(v[4], v[5], x), mixed(v[6], v[7], x), y);
  return mixed(low, high, z);
}

/// Of the density in one of the cells, over part of the stretches; in units of their lengths. Two
/// Gauss points are exact for a cubic.
BRUME_KERNEL inline Lanes integralOver(const SlabRay& ray, const SlabStretches& s,
                                       std::size_t cell, const Lanes& from, const Lanes& to) {
  Lanes voxels[8];
  loadVoxels(ray, s, cell, voxels);
  const Lanes half = Lanes::all(0.5f) * (to - from), middle = Lanes::all(0.5f) * (to + from),
              node = half * Lanes::all(static_cast<float>(kGauss2));
  return half * (densityAt(ray, s, cell, voxels, middle - node) +
                 densityAt(ray, s, cell, voxels, middle + node));
}

BRUME_KERNEL inline void integrate(const SlabRay& ray, const SlabStretches& s,
                                   SlabIntegrals& result) {
  const Lanes firstCut = Lanes::load(s.cut[0].data()), lastCut = Lanes::load(s.cut[1].data());
  Lanes sum = integralOver(ray, s, 0, Lanes::all(0), firstCut);
  if (s.isUsed[1] != 0) sum = sum + integralOver(ray, s, 1, firstCut, lastCut);
  if (s.isUsed[2] != 0) sum = sum + integralOver(ray, s, 2, lastCut, Lanes::all(1));
  const Doubles length = Doubles::load(s.end.data()) - Doubles::load(s.start.data());
  (widen(sum) * length).store(result.data());
}

/// Bernstein coefficients of the density in one of the cells over part of the stretches: the
/// blossom of the trilinear function, all convex combinations of the voxels.
BRUME_KERNEL inline void findCubics(const SlabRay& ray, const SlabStretches& s, std::size_t cell,
                                    const Lanes& from, const Lanes& to, SlabCubics& cubics) {
  Lanes v[8], b[8], ends[2];
  loadVoxels(ray, s, cell, v);
  // Restrict to the box with the two ends as corners, one axis after another; bit set: the far one.
  const auto setEnds = [&](std::size_t axis) BRUME_KERNEL {
    ends[0] = between(ray, s, cell, axis, from);
    ends[1] = between(ray, s, cell, axis, to);
  };
  setEnds(0);
  for (int i = 0; i < 8; ++i) b[i] = mixed(v[i & 6], v[i | 1], ends[i & 1]);
  setEnds(1);
  for (int i = 0; i < 8; ++i) v[i] = mixed(b[i & 5], b[i | 2], ends[i >> 1 & 1]);
  setEnds(2);
  for (int i = 0; i < 8; ++i) b[i] = mixed(v[i & 3], v[i | 4], ends[i >> 2]);
  const Lanes third = Lanes::all(1.f / 3);
  b[0].store(cubics[cell][0].data());
  (third * (b[1] + b[2] + b[4])).store(cubics[cell][1].data());
  (third * (b[3] + b[5] + b[6])).store(cubics[cell][2].data());
  b[7].store(cubics[cell][3].data());
}

BRUME_KERNEL inline void findCubics(const SlabRay& ray, const SlabStretches& s,
                                    SlabCubics& cubics) {
  const Lanes firstCut = Lanes::load(s.cut[0].data()), lastCut = Lanes::load(s.cut[1].data());
  findCubics(ray, s, 0, Lanes::all(0), firstCut, cubics);
  if (s.isUsed[1] != 0) findCubics(ray, s, 1, firstCut, lastCut, cubics);
  if (s.isUsed[2] != 0) findCubics(ray, s, 2, lastCut, Lanes::all(1), cubics);
}
