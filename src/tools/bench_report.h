// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tools/bench_config.h"
#include "tools/bench_curve.h"
#include "tools/bench_entry.h"
#include "tools/json_object.h"

namespace brume {

/// All renders of one scene and what they are compared with.
struct BenchedScene {
  const BenchScene* scene = nullptr;
  std::string referenceFile;
  std::string failure;   ///< of its reference: it has no entries
  bool isFault = false;  ///< the failure is one of brume
  std::vector<BenchEntry> entries;
};

/// The figures: what results.json holds. Reads every image; an entry whose images cannot be
/// compared gets a failure.
Json benchResults(const BenchConfig& config, std::vector<BenchedScene>& scenes);
/// One page with those figures and the last images, which opens from disk and asks for nothing
/// else.
std::string benchPage(const Json& results, const std::vector<BenchedScene>& scenes);

}  // namespace brume
