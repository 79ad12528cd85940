#include "live.hpp"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "calibrated_sensors.hpp"
#include "format.hpp"
#include "interrupt.hpp"
#include "live_input.hpp"
#include "live_output.hpp"
#include "live_page.hpp"
#include "live_queue.hpp"
#include "misuse.hpp"
#include "plumbline/io/calibration.hpp"
#include "recording_options.hpp"
#include "run_files.hpp"
#include "run_map.hpp"
#include "run_tally.hpp"
#include "runner.hpp"
#include "stream_message.hpp"
#include "stream_socket.hpp"

namespace io = plumbline::io;
namespace pl = plumbline;

namespace {

std::optional<io::Calibration> calibration_of(const LiveOptions& options) {
  if (!options.calibration) return std::nullopt;
  return options.imu_calibration ? io::read_calibration(*options.calibration, *options.imu_calibration)
                                 : io::read_calibration(*options.calibration);
}

/// Reads the messages up to the first frame or IMU sample, which it returns; nothing where the stream is over before
/// it.
std::optional<Message> read_calibrations(MessageReader& reader, const LiveOptions& options,
                                         std::optional<io::Calibration>& calibration) {
  for (;;) {
    std::optional<Message> message = reader.next();
    if (!message || message->type == MessageType::end) return std::nullopt;
    if (message->type != MessageType::calibration) return message;
    if (!options.calibration) read_calibration_message(*message, calibration);
  }
}

/// Puts what the stream has into the queue, in a thread of its own.
class StreamThread {
 public:
  StreamThread(MessageReader& reader, const Configuration& configuration, const io::Calibration& calibration,
               LiveQueue& queue, Message first)
      : reader_(reader), needs_(configuration.needs), calibration_(calibration), queue_(queue) {
    thread_ = std::thread([this, first = std::move(first)]() mutable { run(std::move(first)); });
  }
  StreamThread(const StreamThread&) = delete;
  StreamThread& operator=(const StreamThread&) = delete;
  ~StreamThread() { thread_.join(); }

 private:
  void run(Message first) {
    try {
      for (std::optional<Message> message = std::move(first); message && take(*message);) message = reader_.next();
      queue_.end(nullptr);
    } catch (...) {
      queue_.end(std::current_exception());
    }
  }

  /// False after the last message.
  bool take(Message& message) {
    if (message.type == MessageType::end) return false;
    if (message.type == MessageType::calibration) throw StreamError(message, "a calibration comes before all samples");
    if (message.type == MessageType::imu) {
      for (const pl::ImuSample& sample : imu_samples_of(message))
        if (needs_.imu && !queue_.add(sample))
          throw StreamError(message, std::to_string(LiveQueue::most_imu) + " samples wait for a frame");
      return true;
    }
    const pl::TimeNs stamp_ns = stamp_of(message, calibration_.camera);
    if (message.type == MessageType::depth) {
      depth_ = std::move(message);
      depth_ns_ = stamp_ns;
      return true;
    }
    if (!needs_.depth) depth_.reset();
    if (depth_ && depth_ns_ != stamp_ns)
      throw StreamError(message, "its time stamp is not that of the depth image before it");
    queue_.add({stamp_ns, frame_time(needs_, calibration_, stamp_ns), std::move(message), std::exchange(depth_, {})});
    return true;
  }

  MessageReader& reader_;
  Needs needs_;
  const io::Calibration& calibration_;
  LiveQueue& queue_;
  std::optional<Message> depth_;
  pl::TimeNs depth_ns_ = 0;
  std::thread thread_;
};

/// One run: the estimator's side.
class Live {
 public:
  Live(const Configuration& configuration, const LiveOptions& options, const io::Calibration& calibration,
       const Connection& connection, LiveQueue& queue, RunFiles& files, LivePage* page)
      : depth_scale_(calibration.depth_scale),
        runner_(configuration.make(
            calibration, {options.with_map || options.loaded_map || options.saved_map, options.localize_only})),
        output_(connection, options.format, runner_->map_summary().has_value()),
        queue_(queue),
        files_(files),
        page_(page) {
    if (options.loaded_map) load_map(*options.loaded_map, *runner_);
    found_map_ = !options.loaded_map;
  }

  /// Until the stream is over. Throws StreamError and Interrupted.
  void run() {
    while (std::optional<LiveSample> sample = queue_.next(runner_->time_offset_s())) {
      if (const pl::ImuSample* imu = std::get_if<pl::ImuSample>(&*sample))
        runner_->add_imu(*imu);
      else
        add(std::get<LiveFrame>(*sample));
      if (Interruptible::is_asked_to_stop()) break;
    }
    say_dropped();
  }

  const RunTally& tally() const { return tally_; }
  /// False where no place of the loaded map was recognized.
  bool has_found_map() const { return found_map_; }
  std::optional<MapSummary> map_summary() const { return runner_->map_summary(); }
  /// The run is over.
  void finish() {
    if (files_.has_map()) files_.add_map(runner_->saved_map());
    if (page_) show_map();
  }

 private:
  void show_map() {
    if (std::optional<MapSnapshot> map = runner_->map_snapshot(LivePage::most_points)) page_->set_map(std::move(*map));
  }
  void add(const LiveFrame& frame) {
    say_dropped();
    Images images;
    try {
      images = images_of(frame, depth_scale_);
    } catch (const std::runtime_error& damage) {
      tally_.skip();
      print_note(std::string("skipped: ") + damage.what());
      output_.add_event({{"event", "skipped"}, {"stamp_ns", frame.stamp_ns}, {"text", damage.what()}});
      return;
    }
    const FrameOutput result = runner_->add_frame(frame.t_ns, images.gray, images.depth);
    tally_.add(result, result.has_sound_pose());
    if (result.refused) {
      const std::string why = name_of(*result.refused);
      print_note("refused: " + name_of(frame.gray) + ": " + why);
      output_.add_event({{"event", "refused"}, {"stamp_ns", frame.stamp_ns}, {"text", why}});
      return;
    }
    if (result.has_sound_pose()) files_.add_pose(result.pose_ns(), result);
    output_.add(frame.stamp_ns, result, queue_.waiting());
    const bool is_in_trajectory = result.has_sound_pose() && result.is_in_map;
    found_map_ = found_map_ || is_in_trajectory;
    if (!page_) return;
    if (page_->wants_map()) show_map();
    page_->add(result, is_in_trajectory, dropped_);
  }

  /// Each time on the output; as a note when their number has doubled.
  void say_dropped() {
    const std::size_t all = queue_.dropped();
    if (all == dropped_) return;
    output_.add_event({{"event", "dropped"}, {"frames", all - dropped_}, {"frames_in_all", all}});
    if (all >= 2 * noted_) {
      print_note("falls behind: " + std::to_string(all) + " frames are dropped so far (--wait lets the sender wait)");
      noted_ = all;
    }
    dropped_ = all;
  }

  double depth_scale_;
  std::unique_ptr<Runner> runner_;
  LiveOutput output_;
  LiveQueue& queue_;
  RunFiles& files_;
  LivePage* page_;  // or none
  bool found_map_ = true;
  RunTally tally_;
  std::size_t dropped_ = 0, noted_ = 0;
};

void print_summary(const Live& live, const LiveQueue& queue) {
  const std::string dropped = queue.dropped() > 0 ? format("; %zu frames dropped", queue.dropped()) : "";
  const std::string waited =
      queue.sender_waited_s() > 0.01 ? format("; the sender waited %.1f s", queue.sender_waited_s()) : "";
  std::fprintf(stderr, "%s%s%s\n", live.tally().summary().c_str(), dropped.c_str(), waited.c_str());
  if (const auto map = live.map_summary()) std::fprintf(stderr, "%s\n", summary_of(*map).c_str());
}

}  // namespace

int run_live(const LiveOptions& options) {
  const Configuration& configuration = configuration_named(options.config);
  if (options.imu_calibration && !options.calibration) throw Misuse("--imu-calibration: goes with --calibration");
  std::optional<io::Calibration> calibration = calibration_of(options);
  RunPaths paths;
  paths.trajectory = options.trajectory;
  paths.map = options.saved_map;
  std::vector<std::filesystem::path> inputs;
  for (const auto& file : {options.calibration, options.imu_calibration, options.mask})
    if (file) inputs.push_back(*file);
  if (options.loaded_map && options.loaded_map != options.saved_map) inputs.push_back(*options.loaded_map);
  RunFiles files(paths, inputs);

  std::unique_ptr<LivePage> page;
  if (options.page)
    page = std::make_unique<LivePage>(*options.page, "plumbline live: " + options.config, configuration.needs.imu);

  const Interruptible interruptible;
  std::atomic<bool> stop = false;
  const std::unique_ptr<Connection> connection =
      options.address.empty() ? std::make_unique<Connection>() : std::make_unique<Connection>(options.address);
  MessageReader reader(connection->input(), stop);
  std::optional<Message> first = read_calibrations(reader, options, calibration);
  if (!first) throw StreamError("has no frames");
  if (!calibration) throw StreamError(*first, "no calibration comes before it, and --calibration names none");
  if (options.depth_scale > 0) calibration->depth_scale = options.depth_scale;
  if (options.mask) calibration->mask = options.mask;
  const std::string name = options.calibration ? options.calibration->string() : "stream: calibration";
  require_calibrated(configuration, *calibration, name);
  print_notes(calibration->notes);

  LiveQueue queue({options.queue, options.sender_waits, configuration.needs.imu}, stop);
  Live live(configuration, options, *calibration, *connection, queue, files, page.get());
  std::exception_ptr fault;
  {
    const StreamThread thread(reader, configuration, *calibration, queue, std::move(*first));
    try {
      live.run();
    } catch (...) {
      fault = std::current_exception();
    }
    stop = true;
  }
  live.finish();
  print_summary(live, queue);
  if (!live.has_found_map()) print_notes({not_found_in(*options.loaded_map)});
  files.commit_all();
  if (page && !Interruptible::is_asked_to_stop()) {
    page->set_over();
    print_note("the page stays until Ctrl-C");
    while (!Interruptible::is_asked_to_stop()) std::this_thread::sleep_for(std::chrono::milliseconds(100));
    if (!fault) return 0;
  }
  if (fault) std::rethrow_exception(fault);
  if (Interruptible::is_asked_to_stop()) throw Interrupted("interrupted; what came before is written");
  return 0;
}
