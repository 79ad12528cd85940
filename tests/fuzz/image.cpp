// Any bytes as the file of an image (PNG, JPEG, PGM): gray of 8 bits, gray of 16 of which 12 are used, depth. Pixels
// have the type that is promised, or a std::runtime_error says in one line what is wrong.
#include <string_view>

#include "checksums.hpp"
#include "fuzz_folder.hpp"
#include "plumbline/opencv/image_file.hpp"

namespace {

template <class Read>
void require_type(int type, Read&& read) {
  try {
    const cv::Mat image = read();
    require(image.type() == type && !image.empty(), "an image has pixels of the type that is promised");
  } catch (const std::runtime_error& error) {
    const std::string_view what = error.what();
    require(what.starts_with("a.png: ") && what.find('\n') == what.npos, "an error names the file, in one line");
  }
}

}  // namespace

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  size = LLVMFuzzerMutate(data, size, max_size);
  if (seed % 2 == 0 && text_of(data, size).starts_with("\x89PNG")) repair_png({data, size});
  return size;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace plumbline::opencv;
  const auto read = [&](int flags) { return decode_image({data, size}, flags, "a.png"); };
  require_type(CV_8UC1, [&] { return gray_of(read, 16); });
  require_type(CV_8UC1, [&] { return gray_of(read, 12); });
  require_type(CV_16UC1, [&] { return depth_of(read, 1000, "a.png"); });
  const int bits = used_gray_bits(1, [&](std::size_t, int flags) { return read(flags); });
  require(bits >= 8 && bits <= 16 && bits % 2 == 0, "8 to 16 bits are used");
  return 0;
}
