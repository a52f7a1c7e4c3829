// SPDX-License-Identifier: Apache-2.0
// Beam searches in a PhotonBvhView, included once for each kind of Lanes (lanes.h).

/// The projection of boxes to an axis through o.
struct AxisTest {
  Lanes x, y, z, atOrigin;
  std::array<bool, 3> isNegative;

  BRUME_KERNEL AxisTest(const Vec3& axis, const Vec3& o)
      : x(Lanes::all(axis.x)),
        y(Lanes::all(axis.y)),
        z(Lanes::all(axis.z)),
        atOrigin(Lanes::all(dot(axis, o))),
        isNegative{axis.x < 0, axis.y < 0, axis.z < 0} {}

  using Corners = std::array<std::array<float, kLanes>, 3>;
  BRUME_KERNEL Lanes along(const Corners& ifPositive, const Corners& ifNegative) const {
    return x * Lanes::load((isNegative[0] ? ifNegative : ifPositive)[0].data()) +
           y * Lanes::load((isNegative[1] ? ifNegative : ifPositive)[1].data()) +
           z * Lanes::load((isNegative[2] ? ifNegative : ifPositive)[2].data()) - atOrigin;
  }
  BRUME_KERNEL Lanes lowest(const PhotonTreeView::Node& node) const {
    return along(node.lo, node.hi);
  }
  BRUME_KERNEL Lanes highest(const PhotonTreeView::Node& node) const {
    return along(node.hi, node.lo);
  }
  /// From the origin to the nearest point of the projection.
  BRUME_KERNEL Lanes distance(const PhotonTreeView::Node& node) const {
    const Lanes zero = Lanes::all(0);
    return max(max(lowest(node), zero - highest(node)), zero);
  }
};

/// A beam against the boxes of a node: in a frame along the beam, where the foot of a photon is its
/// projection, so boxes need no widening along the beam; sideways the rectangle around the
/// projected box is within the radius. Widened by the slack of beamFoot.
struct BeamTest {
  AxisTest d, u, v;
  Lanes t0, t1, slack;

  BRUME_KERNEL BeamTest(const BeamQuery& beam, const Frame& frame, float slack_)
      : d(beam.d, beam.o),
        u(frame.x, beam.o),
        v(frame.y, beam.o),
        t0(Lanes::all(beam.range.t0 - slack_)),
        t1(Lanes::all(beam.range.t1 + slack_)),
        slack(Lanes::all(slack_)) {}

  BRUME_KERNEL LaneMask mayHold(const PhotonTreeView::Node& node, const Lanes& radii) const {
    const Lanes du = u.distance(node), dv = v.distance(node), r = radii + slack;
    return lessEqual(du * du + dv * dv, r * r) & lessEqual(d.lowest(node), t1) &
           lessEqual(t0, d.highest(node));
  }
};

/// One beam against the photons of one block.
struct BlockTest {
  Lanes ox, oy, oz, dx, dy, dz, t0, t1;

  BRUME_KERNEL explicit BlockTest(const BeamQuery& b)
      : ox(Lanes::all(b.o.x)),
        oy(Lanes::all(b.o.y)),
        oz(Lanes::all(b.o.z)),
        dx(Lanes::all(b.d.x)),
        dy(Lanes::all(b.d.y)),
        dz(Lanes::all(b.d.z)),
        t0(Lanes::all(b.range.t0)),
        t1(Lanes::all(b.range.t1)) {}

  BRUME_KERNEL BeamFoot<Lanes> foot(const PhotonTreeView::Block& block) const {
    return beamFoot(ox, oy, oz, dx, dy, dz, Lanes::load(block.x.data()),
                    Lanes::load(block.y.data()), Lanes::load(block.z.data()));
  }
  /// isInBeam.
  BRUME_KERNEL LaneMask holds(const BeamFoot<Lanes>& foot, const Lanes& radius2) const {
    return lessEqual(t0, foot.t) & lessEqual(foot.t, t1) & less(foot.d2, radius2);
  }
};

BRUME_KERNEL inline void append(PhotonBvh::Found& found, std::size_t& count, std::uint32_t block,
                                LaneMask mask, const BeamFoot<Lanes>& foot,
                                const Lanes& radius2) {
  compressIndices(block * std::uint32_t{kLanes}, mask, found.indices.data() + count);
  compress(foot.t, mask, found.t.data() + count);
  compress(foot.d2, mask, found.distances2.data() + count);
  compress(radius2, mask, found.radii2.data() + count);
  count += static_cast<std::size_t>(std::popcount(mask));
}

/// Squared radii of a block's photons; `radii` are those of its node's children.
BRUME_KERNEL inline Lanes radii2Of(const PhotonBvhView& bvh, std::uint32_t block,
                                   const float* radii) {
  switch (bvh.kind) {
    case PhotonBvhView::Radii::Each:
      return Lanes::load(bvh.radii2[block].data());
    case PhotonBvhView::Radii::OfBlocks:
      return Lanes::all(radii[block % kLanes] * radii[block % kLanes]);
    case PhotonBvhView::Radii::Same:
      break;
  }
  return Lanes::all(bvh.radius2);
}

/// Goes on with a search until `found` may be full or nothing is left.
BRUME_KERNEL std::size_t searchBeam(const PhotonBvhView& bvh, PhotonKdTree::Search& search,
                                    const BeamQuery& beam, PhotonBvh::Found& found) {
  const PhotonTreeView& tree = bvh.tree;
  const float reach = tree.maxCoordinate + maxComponent(abs(beam.o));
  const BeamTest nodeTest(beam, Frame::fromZ(beam.d), kBeamSlack * reach);
  const BlockTest blockTest(beam);
  PhotonBvhView::LaneRow sameRadii;
  sameRadii.fill(std::sqrt(bvh.radius2));
  const bool isSame = bvh.kind == PhotonBvhView::Radii::Same;
  std::size_t count = 0;
  while (search.size > 0 && count <= PhotonKdTree::kBatch - PhotonKdTree::kBatchMost) {
    const PhotonKdTree::Search::Entry entry = search.stack[--search.size];
    const float* const radii =
        isSame ? sameRadii.data() : bvh.childRadii[entry.level][entry.node].data();
    LaneMask mask =
        nodeTest.mayHold(tree.levels[entry.level][entry.node], Lanes::load(radii));
    for (; mask != 0; mask &= mask - 1) {
      const std::uint32_t child =
          entry.node * std::uint32_t{kLanes} + static_cast<std::uint32_t>(std::countr_zero(mask));
      if (entry.level > 1) {
        search.stack[search.size++] = {child, entry.level - 1};
        continue;
      }
      const BeamFoot<Lanes> foot = blockTest.foot(tree.blocks[child]);
      const Lanes radius2 = radii2Of(bvh, child, radii);
      append(found, count, child, blockTest.holds(foot, radius2), foot, radius2);
    }
  }
  return count;
}
