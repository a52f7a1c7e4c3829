// SPDX-License-Identifier: Apache-2.0
// What photons scatter towards a viewer, eight at a time; included once for each kind of Lanes
// (lanes_math.h).

#include "accelerators/lanes_exp.inl"

/// |v + s wi|^2 for the unit vectors wi that are packed in the lanes (PackedDirection).
BRUME_KERNEL inline Lanes distance2To(const Vec3& v, const Lanes& s, const Lanes& packed) {
  const Lanes one = Lanes::all(1.f), zero = Lanes::all(0.f), scale = Lanes::all(1.f / 32767.f);
  Lanes x = lowerHalf(packed) * scale - one, y = upperHalf(packed) * scale - one;
  const Lanes z = one - max(x, zero - x) - max(y, zero - y);
  const Lanes folded = max(zero - z, zero);
  x = x - withSign(folded, x);
  y = y - withSign(folded, y);
  const Lanes f = s / sqrt(x * x + y * y + z * z);
  const Lanes ex = Lanes::all(v.x) + f * x, ey = Lanes::all(v.y) + f * y,
              ez = Lanes::all(v.z) + f * z;
  return ex * ex + ey * ey + ez * ez;
}

/// The phase function without its constant factor.
template <bool kIsotropic>
BRUME_KERNEL inline Lanes phaseOf(const Viewer& viewer, const Lanes& packed) {
  if constexpr (kIsotropic) return Lanes::all(1.f);
  const Lanes denominator =
      Lanes::all(viewer.oneMinusA2) +
      Lanes::all(viewer.a) * distance2To(viewer.d, Lanes::all(viewer.sign), packed);
  return Lanes::all(1.f) / (denominator * sqrt(denominator));
}

BRUME_KERNEL inline void addTo(std::array<float, kLanes>& sum, const Lanes& term) {
  (Lanes::load(sum.data()) + term).store(sum.data());
}

/// The photons that a search found along a beam, their number rounded up to whole rows.
template <bool kIsotropic>
BRUME_KERNEL inline void addAlongBeam(const float* photons, const Viewer& viewer,
                                      const BeamDepths& depths,
                                      const PhotonBvh::Found& found, std::size_t count,
                                      LaneSums& sums) {
  for (std::size_t i = 0; i < count; i += kLanes) {
    const LaneColumns photon = gatherRows(photons, found.indices.data() + i);
    const Lanes inverse = Lanes::all(1.f) / Lanes::load(found.radii2.data() + i);
    const Lanes q = Lanes::all(1.f) - Lanes::load(found.distances2.data() + i) * inverse;
    const Lanes weight = q * q * inverse * phaseOf<kIsotropic>(viewer, photon.c3);
    const Lanes way = Lanes::load(found.t.data() + i) - Lanes::all(depths.t0);
    const auto minusDepth = [&](std::size_t c) BRUME_KERNEL {
      return depths.known != nullptr
                 ? Lanes::all(0.f) - Lanes::load((*depths.known)[c].data() + i)
                 : way * Lanes::all(-depths.sigma_t[c]);
    };
    const Lanes* const powers[] = {&photon.c0, &photon.c1, &photon.c2};
    if (depths.isGrey) {
      const Lanes grey = weight * expOf(minusDepth(0));
      for (std::size_t c = 0; c < 3; ++c) addTo(sums.L[c], *powers[c] * grey);
    } else {
      for (std::size_t c = 0; c < 3; ++c)
        addTo(sums.L[c], *powers[c] * weight * expOf(minusDepth(c)));
    }
  }
}

/// The photons around a point: those nearer than the radius count.
template <bool kIsotropic>
BRUME_KERNEL inline void addAroundPoint(const float* photons, const Viewer& viewer,
                                        const std::uint32_t* indices, const float* distances2,
                                        std::size_t count, float inverseRadius2, LaneSums& sums) {
  for (std::size_t i = 0; i < count; i += kLanes) {
    const LaneColumns photon = gatherRows(photons, indices + i);
    const Lanes q = max(Lanes::all(0.f), Lanes::all(1.f) - Lanes::load(distances2 + i) *
                                                               Lanes::all(inverseRadius2));
    const Lanes weight = q * q * phaseOf<kIsotropic>(viewer, photon.c3);
    addTo(sums.L[0], photon.c0 * weight);
    addTo(sums.L[1], photon.c1 * weight);
    addTo(sums.L[2], photon.c2 * weight);
  }
}

/// Moves the photons nearer than the radius to the front, in their order; returns how many.
BRUME_KERNEL inline std::size_t keepNearer(float radius2, std::uint32_t* indices,
                                           float* distances2, std::size_t count) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count; i += kLanes) {
    const Lanes d2 = Lanes::load(distances2 + i);
    LaneMask mask = less(d2, Lanes::all(radius2));
    if (count - i < kLanes) mask &= (LaneMask{1} << (count - i)) - 1;
    compress(d2, mask, distances2 + kept);
    compressWords(indices + i, mask, indices + kept);
    kept += static_cast<std::size_t>(std::popcount(mask));
  }
  return kept;
}

BRUME_KERNEL inline void addBeam(const float* photons, const Viewer& viewer,
                                 const BeamDepths& depths, const PhotonBvh::Found& found,
                                 std::size_t count, LaneSums& sums) {
  if (viewer.a == 0)
    addAlongBeam<true>(photons, viewer, depths, found, count, sums);
  else
    addAlongBeam<false>(photons, viewer, depths, found, count, sums);
}

BRUME_KERNEL inline void addPoint(const float* photons, const Viewer& viewer,
                                  const std::uint32_t* indices, const float* distances2,
                                  std::size_t count, float inverseRadius2, LaneSums& sums) {
  if (viewer.a == 0)
    addAroundPoint<true>(photons, viewer, indices, distances2, count, inverseRadius2, sums);
  else
    addAroundPoint<false>(photons, viewer, indices, distances2, count, inverseRadius2, sums);
}
