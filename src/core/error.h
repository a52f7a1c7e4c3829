// SPDX-License-Identifier: Apache-2.0
// The two kinds of failure: the user's (SceneError: file, line, column, text; exit 1) and ours
// (BRUME_CHECK; exit 2).
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace brume {

/// Where something stands in a scene file. The text of the file is kept by the parser (see
/// sourceLine in diagnostics).
struct SourceLocation {
  const std::string* file =
      nullptr;  ///< name as given; owned by the process-wide SourceFiles table; null: command line
  std::uint32_t line = 0;    ///< from 1; 0: the file as a whole
  std::uint32_t column = 0;  ///< from 1; 0: the line as a whole

  bool isKnown() const { return file != nullptr; }
};

/// "file:line:column" (or less, as far as it is known).
std::string toString(const SourceLocation& where);

/// The user's fault: malformed scene, wrong value, unreadable file. main() prints it and exits
/// with 1.
class SceneError : public std::runtime_error {
 public:
  SceneError(const SourceLocation& where, const std::string& text)
      : std::runtime_error(text), where_(where) {}
  explicit SceneError(const std::string& text) : SceneError(SourceLocation{}, text) {}
  const SourceLocation& where() const { return where_; }

 private:
  SourceLocation where_;
};

/// brume's fault: a broken invariant. main() prints it and exits with 2.
class InternalError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

[[noreturn]] void checkFailed(const char* condition, const char* file, int line);

/// " (did you mean 'x'?)" when a choice is near what was written, else "".
std::string nearestSpelling(std::string_view written, const std::vector<std::string>& choices);
/// "'a', 'b' or 'c'".
std::string listChoices(const std::vector<std::string>& choices);

#define BRUME_CHECK(condition) \
  ((condition) ? static_cast<void>(0) : ::brume::checkFailed(#condition, __FILE__, __LINE__))
#ifdef NDEBUG
#define BRUME_DCHECK(condition) static_cast<void>(0)
#else
#define BRUME_DCHECK(condition) BRUME_CHECK(condition)
#endif

}  // namespace brume
