#pragma once
/// The layouts of KITTI: the odometry recordings, and the raw ones with oxts (GPS and IMU).

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "plumbline/io/error.hpp"
#include "plumbline/io/index_rows.hpp"
#include "plumbline/io/recording_files.hpp"

namespace plumbline::io::detail {

/// `digits` wide, zeros before it.
inline std::string numbered(std::size_t i, std::size_t digits) {
  const std::string number = std::to_string(i);
  return std::string(number.size() < digits ? digits - number.size() : 0, '0') + number;
}

/// PNG or JPEG.
inline std::optional<Path> image_named(const Path& stem) {
  std::optional<Path> image;
  for (const char* extension : {".png", ".jpg", ".jpeg"})
    if (!image) image = if_exists(Path(stem).concat(extension));
  return image;
}

/// times.txt has one time for each image; the images are numbered 000000, 000001, ...
inline RecordingFiles read_kitti(const Path& root) {
  RecordingFiles out;
  out.layout = Layout::kitti;
  out.frame_index = root / "times.txt";
  const TimeUnit unit = unit_of(out.frame_index, TimeUnit::seconds, out.notes);
  SkippedRows skipped;
  std::size_t rows = 0;
  bool is_said = false;
  for (RowReader row(out.frame_index); row.next();) {
    const std::size_t number = rows++;
    if (!has_columns(row, 1, out.frame_index, skipped, out.notes, is_said)) continue;
    const TimeNs t = row.time_in(unit);
    if (!is_after(row, out.frames, t, skipped)) continue;
    const Path stem = root / "image_0" / numbered(number, 6);
    if (const std::optional<Path> image = image_named(stem))
      out.frames.push_back({.t_ns = t, .image = *image, .depth = {}, .source = {}});
    else
      skipped.add(row, "the image does not exist", ": " + stem.string() + ".png (or .jpg)");
  }
  skipped.report(out.frame_index, rows, out.notes);
  if (out.frames.empty()) throw ReadError(out.frame_index, 0, "has no times");
  out.calibration = first_existing({root / "calibration.yaml", root / "calib.txt"});
  out.camera_truth = if_exists(root / "poses.txt");
  for (const char* name : {"image_1", "image_2", "image_3"})
    if (const auto camera = if_exists(root / name)) out.other_sensors.push_back(*camera);
  return out;
}

/// "2011-09-26 13:02:25.594360375", in two fields.
inline TimeNs date_time(const RowReader& row) {
  const auto number = [](std::string_view text) { return parse<int>(text); };
  const std::string_view date = row[0], time = row.size() > 1 ? row[1] : std::string_view();
  if (date.size() == 10 && time.size() >= 8) {
    const auto year = number(date.substr(0, 4)), month = number(date.substr(5, 2)), day = number(date.substr(8, 2));
    const auto hour = number(time.substr(0, 2)), minute = number(time.substr(3, 2));
    const auto second = parse_seconds(time.substr(6));
    if (year && month && day && hour && minute && second && *month >= 1 && *day >= 1) {
      const std::chrono::year_month_day ymd{std::chrono::year(*year), std::chrono::month(unsigned(*month)),
                                            std::chrono::day(unsigned(*day))};
      const TimeNs days = std::chrono::sys_days(ymd).time_since_epoch().count();
      if (ymd.ok()) return (days * 86'400 + *hour * 3'600 + *minute * 60) * 1'000'000'000 + *second;
    }
  }
  row.fail("is no time stamp of the form 2011-09-26 13:02:25.594360375");
}

/// One file of oxts: 30 numbers, of which 12 to 14 are the specific force and 18 to 20 the angular rate, x forward, y
/// left and z up.
inline ImuSample read_oxts(const Path& file, TimeNs t) {
  RowReader row(file);
  if (!row.next()) throw ReadError(file, 0, "has no numbers");
  if (row.size() < 20) row.fail("expected 30 columns (oxts), found " + std::to_string(row.size()));
  return {t, {row.number(17), row.number(18), row.number(19)}, {row.number(11), row.number(12), row.number(13)}};
}

/// image_00/{timestamps.txt, data/0000000000.png}, oxts/{timestamps.txt, data/0000000000.txt}; the calibration is in
/// the folder of the day, above.
inline RecordingFiles read_kitti_raw_layout(const Path& root) {
  RecordingFiles out;
  out.layout = Layout::kitti_raw;
  out.frame_index = root / "image_00/timestamps.txt";
  SkippedRows skipped;
  std::size_t rows = 0;
  for (RowReader row(out.frame_index); row.next(); ++rows) {
    const TimeNs t = date_time(row);
    if (!is_after(row, out.frames, t, skipped)) continue;
    const Path stem = root / "image_00/data" / numbered(rows, 10);
    if (const std::optional<Path> image = image_named(stem))
      out.frames.push_back({.t_ns = t, .image = *image, .depth = {}, .source = {}});
    else
      skipped.add(row, "the image does not exist", ": " + stem.string() + ".png (or .jpg)");
  }
  skipped.report(out.frame_index, rows, out.notes);
  if (out.frames.empty()) throw ReadError(out.frame_index, 0, "has no times");

  out.imu_index = if_exists(root / "oxts/timestamps.txt");
  if (out.imu_index) {
    SkippedRows skipped_samples;
    std::size_t samples = 0;
    for (RowReader row(*out.imu_index); row.next(); ++samples) {
      const TimeNs t = date_time(row);
      if (!is_after(row, out.imu, t, skipped_samples)) continue;
      const Path file = root / "oxts/data" / (numbered(samples, 10) + ".txt");
      if (std::filesystem::exists(file))
        out.imu.push_back(read_oxts(file, t));
      else
        skipped_samples.add(row, "the file of oxts does not exist", ": " + file.string());
    }
    skipped_samples.report(*out.imu_index, samples, out.notes);
    if (out.imu.size() > 1 &&
        seconds_between(out.imu.front().t_ns, out.imu.back().t_ns) > 0.03 * double(out.imu.size()))
      out.notes.push_back(out.imu_index->string() +
                          ": oxts has 10 Hz in synchronized drives, too slow for an IMU; the others have 100 Hz");
  }
  const Path day = std::filesystem::weakly_canonical(root).parent_path();
  out.calibration =
      first_existing({root / "calibration.yaml", root / "calib_cam_to_cam.txt", day / "calib_cam_to_cam.txt"});
  for (const char* name : {"image_01", "image_02", "image_03"})
    if (const auto camera = if_exists(root / name)) out.other_sensors.push_back(*camera);
  return out;
}

}  // namespace plumbline::io::detail
