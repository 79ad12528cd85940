#include "open_recording.hpp"

#ifdef PLUMBLINE_HAS_BAG
#include "plumbline/io/bag/bag_recording.hpp"
#endif

namespace io = plumbline::io;

io::Recording open_recording(const std::filesystem::path& path, const io::Recording::Options& options,
                             const TopicOptions& topics) {
#ifdef PLUMBLINE_HAS_BAG
  if (io::bag::is_bag(path))
    return io::bag::open_recording(path, {topics.image, topics.depth, topics.imu, topics.camera_info}, options);
#else
  if (std::filesystem::is_regular_file(path))
    throw io::ReadError(path, 0,
                        "is a file: this program is built without bags (they need libbz2-dev, liblz4-dev, libzstd-dev "
                        "and libsqlite3-dev)");
#endif
  if (!(topics.image + topics.depth + topics.imu + topics.camera_info).empty())
    throw io::ReadError(path, 0, "is a folder of files: topics are chosen of bags");
  return io::Recording::open(path, options);
}
