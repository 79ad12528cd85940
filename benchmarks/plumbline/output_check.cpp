#include "output_check.hpp"

#include <stdexcept>
#include <string>

#include "misuse.hpp"

namespace fs = std::filesystem;

namespace {

/// Whether both names lead to one file, there or not.
bool are_same(const fs::path& a, const fs::path& b) {
  std::error_code error;
  if (fs::exists(a, error) && fs::exists(b, error)) return fs::equivalent(a, b, error);
  return fs::weakly_canonical(fs::absolute(a), error) == fs::weakly_canonical(fs::absolute(b), error);
}

bool is_special(const fs::path& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  return fs::exists(status) && !fs::is_regular_file(status);
}

}  // namespace

void check_outputs(const std::vector<NamedOutput>& outputs, const std::vector<fs::path>& inputs) {
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const NamedOutput& output = outputs[i];
    if (is_special(output.file)) continue;
    for (std::size_t k = 0; k < i; ++k)
      if (are_same(output.file, outputs[k].file))
        throw Misuse(output.file.string() + ": both " + outputs[k].option + " and " + output.option +
                     " name this file");
    std::error_code error;
    if (!fs::exists(output.file, error)) continue;
    for (const fs::path& input : inputs)
      if (are_same(output.file, input))
        throw Misuse(output.file.string() + ": " + output.option + " would overwrite what is read");
  }
}
