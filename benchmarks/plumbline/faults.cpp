#include "faults.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <iostream>
#include <limits>
#include <stdexcept>

#include <opencv2/imgproc.hpp>

#include "compare_json.hpp"
#include "faults_table.hpp"
#include "format.hpp"
#include "misuse.hpp"
#include "nearest.hpp"
#include "trial.hpp"

namespace pl = plumbline;
using nlohmann::json;

namespace {

cv::Mat noise_texture(const cv::Size& size) {
  cv::Mat coarse(size.height / 8 + 1, size.width / 8 + 1, CV_8U), out;
  cv::RNG random(1);
  random.fill(coarse, cv::RNG::UNIFORM, 0, 256);
  cv::resize(coarse, out, size, 0, 0, cv::INTER_CUBIC);
  return out;
}

/// Covers the left half with a texture that is shifted by `shift_px` to the left.
void cover(Picture& picture, int shift_px) {
  const cv::Size half(picture.gray.cols / 2, picture.gray.rows);
  const cv::Mat texture = noise_texture({half.width + shift_px, half.height});
  picture.gray = picture.gray.clone();
  texture(cv::Rect({shift_px, 0}, half)).copyTo(picture.gray(cv::Rect({0, 0}, half)));
  if (!picture.depth.empty()) {
    picture.depth = picture.depth.clone();
    picture.depth(cv::Rect({0, 0}, half)).setTo(0);
  }
}

/// A fault between two times.
struct Interval {
  pl::TimeNs begin_ns, end_ns;
  bool has(pl::TimeNs t_ns) const { return t_ns >= begin_ns && t_ns < end_ns; }
};

struct Fault {
  const char* name;
  double duration_s;  ///< NaN: those of the options; infinite: to the end
  std::function<Spoil(const Interval&)> make;
};

Spoil of_pictures(const Interval& when, const std::function<bool(Picture&)>& spoil) {
  return [=](Event& event) {
    Picture* picture = std::get_if<Picture>(&event);
    return picture == nullptr || !when.has(picture->t_ns) || spoil(*picture);
  };
}
Spoil of_imu_samples(const Interval& when, const std::function<bool(pl::ImuSample&)>& spoil) {
  return [=](Event& event) {
    pl::ImuSample* sample = std::get_if<pl::ImuSample>(&event);
    return sample == nullptr || !when.has(sample->t_ns) || spoil(*sample);
  };
}

/// The picture or IMU sample before the fault, again and again.
Spoil frozen_pictures(const Interval& when) {
  return [=, last = Picture()](Event& event) mutable {
    Picture* picture = std::get_if<Picture>(&event);
    if (picture == nullptr) return true;
    if (when.has(picture->t_ns) && !last.gray.empty()) {
      picture->gray = last.gray;
      picture->depth = last.depth;
    }
    last = *picture;
    return true;
  };
}
Spoil frozen_samples(const Interval& when) {
  return [=, last = pl::ImuSample()](Event& event) mutable {
    pl::ImuSample* sample = std::get_if<pl::ImuSample>(&event);
    if (sample == nullptr) return true;
    if (when.has(sample->t_ns) && last.t_ns > 0) {
      sample->gyro = last.gyro;
      sample->accel = last.accel;
    }
    last = *sample;
    return true;
  };
}
Spoil covered(const Interval& when, int px_per_frame) {
  return of_pictures(when, [=, n = 0](Picture& picture) mutable {
    cover(picture, px_per_frame * n++);
    return true;
  });
}
Spoil gyro_step(const Interval& when, double rad_s) {
  return of_imu_samples(when, [=](pl::ImuSample& s) {
    s.gyro.x() += rad_s;
    return true;
  });
}

constexpr double whole = std::numeric_limits<double>::infinity();
const double of_options = std::nan("");

const std::vector<Fault>& image_faults() {
  static const std::vector<Fault> all{
      {"black", of_options,
       [](const Interval& when) {
         return of_pictures(when, [](Picture& p) {
           p.gray = cv::Mat(p.gray.size(), CV_8U, cv::Scalar(0));
           return true;
         });
       }},
      {"white", of_options,
       [](const Interval& when) {
         return of_pictures(when, [](Picture& p) {
           p.gray = cv::Mat(p.gray.size(), CV_8U, cv::Scalar(255));
           return true;
         });
       }},
      {"blurred", of_options,
       [](const Interval& when) {
         return of_pictures(when, [](Picture& p) {
           cv::Mat blurred;
           cv::blur(p.gray, blurred, {20, 20});
           p.gray = blurred;
           return true;
         });
       }},
      {"frozen", of_options, frozen_pictures},
      {"missing", of_options, [](const Interval& when) { return of_pictures(when, [](Picture&) { return false; }); }},
      {"half covered", of_options, [](const Interval& when) { return covered(when, 0); }},
      {"half moving", of_options, [](const Interval& when) { return covered(when, 4); }},
  };
  return all;
}

const std::vector<Fault>& imu_faults() {
  static const std::vector<Fault> all{
      {"IMU gap", 0.2, [](const Interval& when) { return of_imu_samples(when, [](pl::ImuSample&) { return false; }); }},
      {"IMU frozen", 1, frozen_samples},
      {"gyro +0.05 rad/s", whole, [](const Interval& when) { return gyro_step(when, 0.05); }},
      {"gyro +0.3 rad/s", whole, [](const Interval& when) { return gyro_step(when, 0.3); }},
      {"accel saturated", whole,
       [](const Interval& when) {
         return of_imu_samples(when, [](pl::ImuSample& s) {
           s.accel = s.accel.cwiseMax(-9.5).cwiseMin(9.5);
           return true;
         });
       }},
      {"IMU 30 ms late", whole,
       [](const Interval&) {  // the truth has the time of the IMU: the images are shifted, in the whole run
         return [](Event& event) {
           if (auto* picture = std::get_if<Picture>(&event)) picture->t_ns -= 30'000'000;
           return true;
         };
       }},
      {"accel y inverted", whole,
       [](const Interval& when) {
         return of_imu_samples(when, [](pl::ImuSample& s) {
           s.accel.y() = -s.accel.y();
           return true;
         });
       }},
  };
  return all;
}

/// What a run came to: the error, seconds from the end of the fault to the first `tracking` frame, and frames.
json outcome_of(const std::vector<JudgedFrame>& frames, pl::TimeNs fault_end_ns) {
  double recovered_s = std::nan("");
  int false_frames = 0, lost_frames = 0;
  std::uint32_t resets = 0;
  for (const JudgedFrame& frame : frames) {
    const pl::HealthState state = frame.estimate.health.state;
    false_frames += frame.is_false();
    lost_frames += state == pl::HealthState::lost;
    resets = std::max(resets, frame.estimate.resets);
    if (frame.t_ns >= fault_end_ns && state == pl::HealthState::tracking && std::isnan(recovered_s))
      recovered_s = pl::seconds_between(fault_end_ns, frame.t_ns);
  }
  return {{"ate_m", rounded(ate_of(frames), 6)},
          {"recovered_s", rounded(recovered_s, 3)},
          {"frames", frames.size()},
          {"false_frames", false_frames},
          {"lost_frames", lost_frames},
          {"resets", resets}};
}

/// One fault at all its times.
json run_fault(const Fault& fault, double duration_s, const Configuration& configuration,
               const LoadedRecording& recording, const Trial& clean, int times) {
  json out = {{"name", fault.name}, {"duration_s", rounded(duration_s, 6)}, {"runs", json::array()}};
  for (int k = 1; k <= times; ++k) {
    const pl::TimeNs length_ns = recording.end_ns - recording.begin_ns;
    const pl::TimeNs begin_ns = recording.begin_ns + length_ns / (times + 1) * k;
    const pl::TimeNs end_ns =
        std::isfinite(duration_s) ? begin_ns + std::llround(1e9 * duration_s) : recording.end_ns + length_ns;
    const Trial trial = run_trial(configuration, recording, recording.begin_ns, recording.end_ns,
                                  fault.make({begin_ns, end_ns}), clean.heading);
    out["runs"].push_back(outcome_of(trial.frames, std::isfinite(duration_s) ? end_ns : begin_ns));
    out["runs"].back()["begin_s"] = rounded(pl::seconds_between(recording.begin_ns, begin_ns), 3);
  }
  return out;
}

/// All faults of one configuration on one recording.
json run_faults(const Configuration& configuration, const LoadedRecording& recording, const FaultOptions& options) {
  const Trial clean =
      run_trial(configuration, recording, recording.begin_ns, recording.end_ns, [](Event&) { return true; });
  json group = {{"configuration", configuration.name},
                {"dataset", recording.name},
                {"clean", outcome_of(clean.frames, recording.begin_ns)},
                {"faults", json::array()}};
  print_clean_run(std::cout, group);
  const auto run = [&](const Fault& fault, double duration_s) {
    group["faults"].push_back(run_fault(fault, duration_s, configuration, recording, clean, options.times));
    print_fault(std::cout, group.at("clean"), group["faults"].back());
    std::cout.flush();
  };
  const auto is_chosen = [&](const Fault& fault) {
    return options.kinds.empty() ||
           std::find(options.kinds.begin(), options.kinds.end(), fault.name) != options.kinds.end();
  };
  for (const Fault& fault : image_faults()) {
    for (const double duration_s : options.durations_s) {
      if (is_chosen(fault)) run(fault, duration_s);
    }
  }
  for (const Fault& fault : imu_faults()) {
    if (configuration.needs.imu && is_chosen(fault)) run(fault, fault.duration_s);
  }
  return group;
}

std::string command_of(const FaultOptions& options) {
  std::vector<std::string> words{"plumbline", "faults", "--config"};
  words.insert(words.end(), options.configs.begin(), options.configs.end());
  words.emplace_back("--dataset");
  for (const auto& dataset : options.datasets) words.push_back(name_of_recording(dataset));
  for (const std::string& word : options.inputs.words()) words.push_back(word);
  if (!options.kinds.empty()) words.emplace_back("--fault");
  words.insert(words.end(), options.kinds.begin(), options.kinds.end());
  words.emplace_back("--for");
  for (const double duration_s : options.durations_s) words.push_back(format("%g", duration_s));
  words.insert(words.end(), {"--times", std::to_string(options.times)});
  if (options.with_map) words.emplace_back("--map");
  return command_line(words);
}

}  // namespace

std::vector<std::string> fault_names() {
  std::vector<std::string> names;
  for (const auto* faults : {&image_faults(), &imu_faults()})
    for (const Fault& fault : *faults) names.emplace_back(fault.name);
  return names;
}

int run_faults(const FaultOptions& options) {
  const std::vector<std::string> known = fault_names();
  for (const std::string& name : options.kinds)
    if (std::find(known.begin(), known.end(), name) == known.end()) throw Misuse(unknown_name("fault", name, known));
  check_results(options.results);
  json result = result_of("faults", command_of(options), options.results);
  result["groups"] = json::array();
  for (const std::string& name : options.configs) {
    const Configuration& configuration = configuration_named(name);
    for (const auto& dataset : options.datasets) {
      LoadedRecording recording = load_recording(dataset, configuration, options.inputs);
      print_notes(recording.notes);
      recording.with_map = options.with_map;
      recording.name = name_of_recording(dataset);
      result["groups"].push_back(run_faults(configuration, recording, options));
    }
  }
  write_results(options.results, result);
  return 0;
}
