// SPDX-License-Identifier: Apache-2.0
#include "core/io/float_file.h"

#include <fmt/format.h>

#include "core/io/number_text.h"
#include "core/io/source_file.h"

namespace brume {

std::vector<float> readFloatFile(const std::string& path, const SourceLocation& blame) {
  SourceFile file(InputFile::open(path, InputFile::Accept::RegularFiles, blame),
                  internFileName(path));
  const std::string_view text = file.text();
  const char* p = text.data();
  const char* const end = p + text.size();
  std::vector<float> values;
  while ((p = skipBlanks(p, end)) < end) {
    const NumberText number = parseNumber(p, end);
    if (!number.end || (number.end < end && !endsNumber(*number.end)))
      throw SceneError(file.locate(p), fmt::format("{} is not a number", quoteRun(p, end)));
    const float value = static_cast<float>(number.value);
    if (!std::isfinite(value))
      throw SceneError(file.locate(p), fmt::format("{} is too large", quoteRun(p, end)));
    values.push_back(value);
    p = number.end;
  }
  if (values.empty()) throw SceneError(blame, fmt::format("'{}' holds no numbers", path));
  return values;
}

}  // namespace brume
