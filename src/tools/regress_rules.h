// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tools/regress.h"

namespace brume {

/// One scene of a folder and how it is judged.
struct RegressScene {
  std::string name, file, reference;  ///< FOLDER/NAME.pbrt, FOLDER/NAME.ref.exr
  RegressRules rules;
};

/// The scenes of the folder in alphabetic order, or those that are named. Throws SceneError for an
/// unknown name, a folder without scenes, and rules that are wrong or for scenes that are not
/// there.
std::vector<RegressScene> findRegressScenes(const RegressOptions& options);

}  // namespace brume
