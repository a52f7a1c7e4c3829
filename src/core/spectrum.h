// SPDX-License-Identifier: Apache-2.0
// Conversion of spectra to linear Rec. 709 RGB, as PBRT-v2's RGB build does it (format page,
// "FromSampled").
#pragma once

#include <span>

#include "core/rgb.h"

namespace brume {

/// XYZ = sum over 360..830 nm (1 nm) of the linearly interpolated value times the CIE 1931 matching
/// functions, over the sum of y-bar; then to RGB. Beyond the given wavelengths the end values hold.
/// The pairs need not be sorted. Components may be negative.
Rgb rgbFromSamples(std::span<const float> wavelengths, std::span<const float> values);
/// Planck's law normalised to 1 at 555 nm, as RGB. Temperature in kelvin; black for T <= 0.
Rgb rgbFromBlackbody(float temperature);
Rgb rgbFromXyz(float x, float y, float z);

}  // namespace brume
