// SPDX-License-Identifier: Apache-2.0
// What every method that answers per camera ray from photon maps must do: "vpm" and "bre" run the
// same checks.
#pragma once

#include <string>

namespace brume::test {

/// Albedo 1 under radiance 1 from everywhere shows 1, seen along the normal of a slab.
void checkFurnace(const std::string& method);
/// Means agree with volpath: media that scatter forwards, are coloured, vary, overlap; unscattered
/// light by sampling and by photons.
void checkAgainstVolpath(const std::string& method);
/// The same with walls, a mirror and glass, caustics and indirect light on surfaces and in media.
void checkSurfacesAgainstVolpath(const std::string& method);
/// A lamp on the other side of a wall: black, though photons lie right behind the wall.
void checkWall(const std::string& method);
/// The same bits for 1, 2 and 7 threads.
void checkThreads(const std::string& method);
/// Media that nothing reaches, no light, no medium, no photons: an error or a stated zero.
void checkScarcity(const std::string& method);
/// A ball that moves: a warning, and none where it stands.
void checkMotion(const std::string& method);

}  // namespace brume::test
