// SPDX-License-Identifier: Apache-2.0
#include "core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace brume {

std::string toString(const SourceLocation& where) {
  if (!where.isKnown()) return {};
  if (where.line == 0) return *where.file;
  if (where.column == 0) return fmt::format("{}:{}", *where.file, where.line);
  return fmt::format("{}:{}:{}", *where.file, where.line, where.column);
}

void checkFailed(const char* condition, const char* file, int line) {
  throw InternalError(fmt::format("check failed: {} ({}:{})", condition, file, line));
}

namespace {

// Edit distance of Levenshtein with transpositions of neighbours (optimal string alignment), case
// ignored.
std::size_t editDistance(std::string_view a, std::string_view b) {
  const auto lower = [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  };
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  std::iota(last.begin(), last.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const bool same = lower(a[i - 1]) == lower(b[j - 1]);
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (same ? 0u : 1u)});
      if (i > 1 && j > 1 && lower(a[i - 1]) == lower(b[j - 2]) &&
          lower(a[i - 2]) == lower(b[j - 1]))
        row[j] = std::min(row[j], before[j - 2] + 1);
    }
    std::swap(before, last);
    std::swap(last, row);
  }
  return last[b.size()];
}

}  // namespace

std::string nearestSpelling(std::string_view written, const std::vector<std::string>& choices) {
  constexpr std::size_t kLongestWord =
      64;  // longer words are no misspelling of ours, and the distance costs their product
  if (written.empty() || written.size() > kLongestWord) return {};
  std::size_t best = written.size() / 3 + 2;  // at most about a third of the letters may differ
  const std::string* nearest = nullptr;
  for (const std::string& choice : choices) {
    const std::size_t d = editDistance(written, choice);
    if (d < best && d < choice.size()) {
      best = d;
      nearest = &choice;
    }
  }
  return nearest ? fmt::format(" (did you mean '{}'?)", *nearest) : std::string();
}

std::string listChoices(const std::vector<std::string>& choices) {
  std::string text;
  for (std::size_t i = 0; i < choices.size(); ++i) {
    if (i > 0) text += i + 1 == choices.size() ? " or " : ", ";
    text += fmt::format("'{}'", choices[i]);
  }
  return text;
}

}  // namespace brume
