// SPDX-License-Identifier: Apache-2.0
// Evaluation of photons in the beams of a tile, included once for each kind of Lanes (lanes.h), after
// accelerators/beam_search.inl.

/// e^x with a relative error of 1e-7, for x <= 80; below -87 it is e^-87.
BRUME_KERNEL inline Lanes expOf(const Lanes& x) {
  // x = n ln 2 + f: adding 1.5 2^23 leaves n in the lowest bits.
  const Lanes bounded = max(Lanes::all(-87.f), x);
  const Lanes shift = Lanes::all(0x1.8p23f);
  const Lanes shifted = bounded * Lanes::all(0x1.715476p0f) + shift;
  const Lanes n = shifted - shift;
  const Lanes f =
      bounded - n * Lanes::all(0x1.62e4p-1f) - n * Lanes::all(0x1.7f7d1cp-20f);
  Lanes sum = Lanes::all(1.f / 5040);
  for (const float c : {1.f / 720, 1.f / 120, 1.f / 24, 1.f / 6, 0.5f, 1.f, 1.f})
    sum = sum * f + Lanes::all(c);
  return scaleByBits(sum, shifted);
}

/// Adds one photon to the blocks of a tile. Neighbouring beams have it at nearly the same t: the
/// transmittance is computed at one, and continued to the others by a short series.
template <bool kIsotropic, bool kGray>
struct GatherVisitor {
  /// Largest |x| for which 1 + x + x^2/2 + x^3/6 stands for e^x: relative error below 4e-8.
  static constexpr float kSeriesReach = 0.03f;

  const BeamTreeView& tree;
  const TileGather& tile;
  float sigmaMax;
  Lanes wx, wy, wz;         // turned for g < 0
  Lanes a, oneMinusA2;      // a = |g|: denominator (1 - a)^2 + a |d + w|^2
  std::array<float, 3> power;
  float tKnown = kInfinity;  // where the transmittance is known
  std::array<Lanes, 3> arriving;  // power times transmittance to tKnown

  BRUME_KERNEL GatherVisitor(const BeamTreeView& tree_, const TileGather& tile_,
                             const BeamPhoton& photon)
      : tree(tree_), tile(tile_) {
    const float s = photon.g < 0 ? -1.f : 1.f, absG = s * photon.g;
    wx = Lanes::all(s * photon.w.x);
    wy = Lanes::all(s * photon.w.y);
    wz = Lanes::all(s * photon.w.z);
    a = Lanes::all(absG);
    oneMinusA2 = Lanes::all((1.f - absG) * (1.f - absG));
    const float phase = kInv4Pi * (1.f - absG) * (1.f + absG);
    power = {photon.power.r * phase, photon.power.g * phase, photon.power.b * phase};
    sigmaMax = std::max({tile.sigma_t[0], tile.sigma_t[1], tile.sigma_t[2]});
  }

  BRUME_KERNEL void knowAt(float t) {
    tKnown = t;
    std::array<float, kLanes> depths{};
    for (std::size_t c = 0; c < 3; ++c) depths[c] = -tile.sigma_t[c] * (t - tile.tStart);
    expOf(Lanes::load(depths.data())).store(depths.data());
    for (std::size_t c = 0; c < 3; ++c) arriving[c] = Lanes::all(power[c] * depths[c]);
  }

  /// K2 times the phase function, without their constant factors.
  BRUME_KERNEL Lanes weightOf(const BeamTreeView::Block& block, const Lanes& d2) const {
    const Lanes q = Lanes::all(1.f) - d2 * load(block.inverseRadius2);
    if constexpr (kIsotropic) return q * q;
    const Lanes ex = load(block.dx) + wx, ey = load(block.dy) + wy, ez = load(block.dz) + wz;
    const Lanes denominator = oneMinusA2 + a * (ex * ex + ey * ey + ez * ez);
    return q * q / (denominator * sqrt(denominator));
  }

  BRUME_KERNEL static Lanes series(const Lanes& x) {
    const Lanes one = Lanes::all(1.f);
    return one + x * (one + x * (Lanes::all(0.5f) + x * Lanes::all(1.f / 6)));
  }

  BRUME_KERNEL void visit(const BeamTreeView::Block& block, std::uint32_t b, const PhotonLanes& p) {
    const BeamFoot<Lanes> foot = feetOn(block, p);
    const Lanes mask = insideMask(block, foot);
    const LaneMask inside = bitsOf(mask);
    if (inside == 0) return;
    BlockSums& sums = tile.sums[b - tile.blocks.begin];
    countLanes(mask, sums.count.data());
    const Lanes weight = weightOf(block, foot.d2) & mask;
    if (tile.isWide) {
      addFar(sums, weight, (foot.t - load(tree.startsOf(b))) & mask);
      return;
    }

    // Where the series does not reach from what is known, start from a beam of this block.
    const Lanes reach = Lanes::all(kSeriesReach);
    for (bool again = false;; again = true) {
      const Lanes x = (Lanes::all(tKnown) - foot.t) & mask;
      const Lanes depth = x * Lanes::all(sigmaMax);
      if (bitsOf(lessEqualMask(max(depth, Lanes::all(0.f) - depth), reach)) == 0xff) {
        add(sums, weight, x);
        return;
      }
      if (again) break;
      knowAt(firstOf(foot.t, inside));
    }
    addFar(sums, weight, (foot.t - Lanes::all(tile.tStart)) & mask);
  }

  BRUME_KERNEL static float firstOf(const Lanes& values, LaneMask mask) {
    std::array<float, kLanes> v;
    values.store(v.data());
    return v[static_cast<std::size_t>(std::countr_zero(mask))];
  }

  BRUME_KERNEL void add(BlockSums& sums, Lanes weight, const Lanes& x) const {
    if constexpr (kGray) weight = weight * series(x * Lanes::all(tile.sigma_t[0]));
    for (std::size_t c = 0; c < 3; ++c) {
      Lanes L = weight * arriving[c];
      if constexpr (!kGray) L = L * series(x * Lanes::all(tile.sigma_t[c]));
      (Lanes::load(sums.L[c].data()) + L).store(sums.L[c].data());
    }
  }

  /// With an exponential for each beam.
  BRUME_KERNEL void addFar(BlockSums& sums, const Lanes& weight, const Lanes& way) const {
    for (std::size_t c = 0; c < 3; ++c) {
      const Lanes Tr = expOf(way * Lanes::all(-tile.sigma_t[c]));
      const Lanes L = weight * Tr * Lanes::all(power[c]);
      (Lanes::load(sums.L[c].data()) + L).store(sums.L[c].data());
    }
  }
};

template <bool kGray>
BRUME_KERNEL inline void gatherPhotons(const BeamTreeView& tree, std::size_t tile,
                                       std::span<const BeamPhoton> photons,
                                       std::span<const std::uint32_t> indices,
                                       const TileGather& gather) {
  for (const std::uint32_t i : indices) {
    const BeamPhoton& photon = photons[i];
    const PhotonLanes p(photon.p);
    if (photon.g == 0) {
      GatherVisitor<true, kGray> visitor(tree, gather, photon);
      visitTile(tree, tile, p, visitor);
    } else {
      GatherVisitor<false, kGray> visitor(tree, gather, photon);
      visitTile(tree, tile, p, visitor);
    }
  }
}

/// The sums of a block in their unit: with the kernel's factor, and transmittance counted from each
/// beam's start.
BRUME_KERNEL inline void finishBlock(const BeamTreeView& tree, const TileGather& gather,
                                     std::uint32_t b, BlockSums& sums) {
  const Lanes peak = load(tree.blocks[b].inverseRadius2) * Lanes::all(3.f * kInvPi);
  for (std::size_t c = 0; c < 3; ++c) {
    Lanes L = Lanes::load(sums.L[c].data()) * peak;
    if (!gather.isWide) {
      const Lanes before = load(tree.startsOf(b)) - Lanes::all(gather.tStart);
      L = L * expOf(before * Lanes::all(gather.sigma_t[c]));
    }
    L.store(sums.L[c].data());
  }
}

/// Adds the photons to gather.sums and finishes these.
BRUME_KERNEL inline void gatherInTile(const BeamTreeView& tree, std::size_t tile,
                                      std::span<const BeamPhoton> photons,
                                      std::span<const std::uint32_t> indices,
                                      const TileGather& gather) {
  if (gather.isGray)
    gatherPhotons<true>(tree, tile, photons, indices, gather);
  else
    gatherPhotons<false>(tree, tile, photons, indices, gather);
  for (std::uint32_t b = gather.blocks.begin; b < gather.blocks.end; ++b)
    if (gather.sums[b - gather.blocks.begin].isTouched()) 
      finishBlock(tree, gather, b, gather.sums[b - gather.blocks.begin]);
}
