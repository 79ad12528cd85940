#include "faults.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <optional>
#include <stdexcept>

#include <opencv2/imgproc.hpp>

#include "nearest.hpp"
#include "statistics.hpp"
#include "trial.hpp"

namespace pl = plumbline;

namespace {

cv::Mat noise_texture(const cv::Size& size) {
  cv::Mat coarse(size.height / 8 + 1, size.width / 8 + 1, CV_8U), out;
  cv::RNG random(1);
  random.fill(coarse, cv::RNG::UNIFORM, 0, 256);
  cv::resize(coarse, out, size, 0, 0, cv::INTER_CUBIC);
  return out;
}

/// Covers the left half with a texture that stands `shift_px` further left.
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
  double duration_s;  ///< NaN: those asked for; infinite: to the end
  std::function<Spoil(const Interval&)> make;
};

Spoil of_pictures(const Interval& when, const std::function<bool(Picture&)>& spoil) {
  return [=](Event& event) {
    Picture* picture = std::get_if<Picture>(&event);
    return picture == nullptr || !when.has(picture->t_ns) || spoil(*picture);
  };
}
Spoil of_readings(const Interval& when, const std::function<bool(pl::ImuSample&)>& spoil) {
  return [=](Event& event) {
    pl::ImuSample* sample = std::get_if<pl::ImuSample>(&event);
    return sample == nullptr || !when.has(sample->t_ns) || spoil(*sample);
  };
}

/// The picture or reading before the fault, again and again.
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
Spoil frozen_readings(const Interval& when) {
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
  return of_readings(when, [=](pl::ImuSample& s) {
    s.gyro.x() += rad_s;
    return true;
  });
}

constexpr double whole = std::numeric_limits<double>::infinity();
const double asked = std::nan("");

const std::vector<Fault>& image_faults() {
  static const std::vector<Fault> all{
      {"black", asked,
       [](const Interval& when) {
         return of_pictures(when, [](Picture& p) {
           p.gray = cv::Mat(p.gray.size(), CV_8U, cv::Scalar(0));
           return true;
         });
       }},
      {"white", asked,
       [](const Interval& when) {
         return of_pictures(when, [](Picture& p) {
           p.gray = cv::Mat(p.gray.size(), CV_8U, cv::Scalar(255));
           return true;
         });
       }},
      {"blurred", asked,
       [](const Interval& when) {
         return of_pictures(when, [](Picture& p) {
           cv::Mat blurred;
           cv::blur(p.gray, blurred, {20, 20});
           p.gray = blurred;
           return true;
         });
       }},
      {"frozen", asked, frozen_pictures},
      {"missing", asked, [](const Interval& when) { return of_pictures(when, [](Picture&) { return false; }); }},
      {"half covered", asked, [](const Interval& when) { return covered(when, 0); }},
      {"half moving", asked, [](const Interval& when) { return covered(when, 4); }},
  };
  return all;
}

const std::vector<Fault>& imu_faults() {
  static const std::vector<Fault> all{
      {"IMU gap", 0.2, [](const Interval& when) { return of_readings(when, [](pl::ImuSample&) { return false; }); }},
      {"IMU frozen", 1, frozen_readings},
      {"gyro +0.05 rad/s", whole, [](const Interval& when) { return gyro_step(when, 0.05); }},
      {"gyro +0.3 rad/s", whole, [](const Interval& when) { return gyro_step(when, 0.3); }},
      {"accel clipped", whole,
       [](const Interval& when) {
         return of_readings(when, [](pl::ImuSample& s) {
           s.accel = s.accel.cwiseMax(-9.5).cwiseMin(9.5);
           return true;
         });
       }},
      {"IMU 30 ms late", whole,
       [](const Interval&) {  // the truth is told by its clock: what differs is the camera's, all the time
         return [](Event& event) {
           if (auto* picture = std::get_if<Picture>(&event)) picture->t_ns -= 30'000'000;
           return true;
         };
       }},
      {"accel y turned", whole,
       [](const Interval& when) {
         return of_readings(when, [](pl::ImuSample& s) {
           s.accel.y() = -s.accel.y();
           return true;
         });
       }},
  };
  return all;
}

struct Outcome {
  double ate_m, recovered_s;  ///< infinite: not any more
  int wrong = 0, lost = 0;    ///< frames
  unsigned resets = 0;
};

Outcome outcome_of(const std::vector<JudgedFrame>& frames, pl::TimeNs fault_end_ns) {
  Outcome out{ate_of(frames), 0};
  for (const JudgedFrame& frame : frames) {
    const pl::HealthState state = frame.estimate.health.state;
    out.wrong += frame.is_false();
    out.lost += state == pl::HealthState::lost;
    out.resets = std::max(out.resets, frame.estimate.resets);
    if (frame.t_ns >= fault_end_ns && state == pl::HealthState::tracking && out.recovered_s == 0)
      out.recovered_s = pl::seconds_between(fault_end_ns, frame.t_ns);
  }
  if (out.recovered_s == 0) out.recovered_s = whole;
  return out;
}

void print_row(const Fault& fault, double duration_s, double clean_m, const std::vector<Outcome>& outcomes) {
  std::vector<double> ate_m;
  double recovered_s = 0;
  int wrong = 0, lost = 0;
  unsigned resets = 0;
  for (const Outcome& each : outcomes) {
    ate_m.push_back(each.ate_m);
    recovered_s = std::max(recovered_s, each.recovered_s);
    wrong += each.wrong;
    lost += each.lost;
    resets += each.resets;
  }
  const double worst_m = *std::max_element(ate_m.begin(), ate_m.end());
  char length[16] = "";
  if (std::isfinite(duration_s)) std::snprintf(length, sizeof length, "%g s", duration_s);
  std::printf("%-17s %6s %9.4f %9.4f %6.2f %7.2f %6d %6d %7u\n", fault.name, length, median(ate_m), worst_m,
              worst_m / clean_m, recovered_s, wrong, lost, resets);
  std::fflush(stdout);
}

void run_faults(const Configuration& configuration, const LoadedRecording& recording, const FaultOptions& options) {
  const auto run = [&](const Spoil& spoil, const std::optional<pl::SO3<double>>& heading = std::nullopt) {
    return run_trial(configuration, recording, recording.begin_ns, recording.end_ns, spoil, heading);
  };
  const Trial clean_trial = run([](Event&) { return true; });
  const std::vector<JudgedFrame>& clean = clean_trial.frames;
  const double clean_m = ate_of(clean);
  const auto wrong = std::count_if(clean.begin(), clean.end(), [](const JudgedFrame& f) { return f.is_false(); });
  std::printf("%s on %s: %.4f m, %zu frames, %ld falsely tracking\n", configuration.name, recording.name.c_str(),
              clean_m, clean.size(), static_cast<long>(wrong));
  std::printf("%-17s %6s %9s %9s %6s %7s %6s %6s %7s\n", "fault", "", "median", "worst m", "ratio", "back s", "false",
              "lost", "resets");
  const auto show = [&](const Fault& fault, double duration_s) {
    std::vector<Outcome> outcomes;
    for (int k = 1; k <= options.times; ++k) {
      const pl::TimeNs length_ns = recording.end_ns - recording.begin_ns;
      const pl::TimeNs begin_ns = recording.begin_ns + length_ns / (options.times + 1) * k;
      const pl::TimeNs end_ns =
          std::isfinite(duration_s) ? begin_ns + std::llround(1e9 * duration_s) : recording.end_ns + length_ns;
      const Trial trial = run(fault.make({begin_ns, end_ns}), clean_trial.heading);
      outcomes.push_back(outcome_of(trial.frames, std::isfinite(duration_s) ? end_ns : begin_ns));
    }
    print_row(fault, duration_s, clean_m, outcomes);
  };
  const auto asked_for = [&](const Fault& fault) {
    return options.kinds.empty() ||
           std::find(options.kinds.begin(), options.kinds.end(), fault.name) != options.kinds.end();
  };
  for (const Fault& fault : image_faults()) {
    for (const double duration_s : options.durations_s) {
      if (asked_for(fault)) show(fault, duration_s);
    }
  }
  if (!configuration.needs.imu) return;
  for (const Fault& fault : imu_faults()) {
    if (asked_for(fault)) show(fault, fault.duration_s);
  }
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
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw std::runtime_error(unknown_name("fault", name, known));
  for (const std::string& name : options.configs) {
    const Configuration& configuration = configuration_named(name);
    for (const auto& dataset : options.datasets)
      run_faults(configuration, load_recording(dataset, configuration.needs), options);
  }
  return 0;
}
