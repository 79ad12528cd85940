#include "child_process.hpp"

#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <memory>
#include <stdexcept>
#include <string_view>
#include <thread>
#include <vector>

#include "format.hpp"

namespace {

using Seconds = std::chrono::duration<double>;
using SteadyTime = std::chrono::steady_clock::time_point;

volatile std::sig_atomic_t stop_asked = 0;
void ask_to_stop(int) { stop_asked = 1; }

/// SIGINT and SIGTERM ask to stop while this lives; not where they are ignored, as in the background of a script.
class StopSignals {
 public:
  StopSignals() {
    stop_asked = 0;
    struct sigaction action = {};
    action.sa_handler = ask_to_stop;
    for (std::size_t i = 0; i < signals.size(); ++i) {
      sigaction(signals[i], nullptr, &before_[i]);
      if (before_[i].sa_handler != SIG_IGN) sigaction(signals[i], &action, nullptr);
    }
  }
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;
  ~StopSignals() {
    for (std::size_t i = 0; i < signals.size(); ++i) sigaction(signals[i], &before_[i], nullptr);
  }

 private:
  static constexpr std::array<int, 2> signals = {SIGINT, SIGTERM};
  std::array<struct sigaction, 2> before_{};
};

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

struct Child {
  std::size_t index;
  pid_t pid;
  std::unique_ptr<std::FILE, CloseFile> output;  ///< what it prints
  SteadyTime begin = std::chrono::steady_clock::now();
  bool is_late = false;  ///< and was stopped for it
};

/// In the child, which does not outlive its parent and leaves the signals of the terminal to it.
[[noreturn]] void do_work(const std::function<void(std::size_t)>& work, std::size_t index, std::FILE* output) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  std::signal(SIGINT, SIG_IGN);
  std::signal(SIGTERM, SIG_IGN);
  dup2(fileno(output), STDOUT_FILENO);
  dup2(fileno(output), STDERR_FILENO);
  try {
    work(index);
    _exit(0);
  } catch (const std::exception& error) {
    dprintf(STDERR_FILENO, "%s\n", error.what());
    _exit(1);
  }
}

Child start(const std::function<void(std::size_t)>& work, std::size_t index) {
  std::unique_ptr<std::FILE, CloseFile> output(std::tmpfile());
  if (!output) throw std::runtime_error(std::string("no temporary file: ") + std::strerror(errno));
  std::fflush(nullptr);  // or the child writes it again
  const pid_t pid = fork();
  if (pid < 0) throw std::runtime_error(std::string("no process can be started: ") + std::strerror(errno));
  if (pid == 0) do_work(work, index, output.get());
  return {index, pid, std::move(output)};
}

/// The last line that is not empty.
std::string last_line(std::FILE* file) {
  std::rewind(file);
  std::string line, last;
  for (int c = std::fgetc(file); c != EOF; c = std::fgetc(file)) {
    if (c == '\n') {
      if (!line.empty()) last = line;
      line.clear();
    } else if (c >= ' ' && c != 0x7f && line.size() < 500) {
      line += static_cast<char>(c);
    }
  }
  return line.empty() ? last : line;
}

/// Nothing of a success.
std::string failure_of(const Child& child, int status, double limit_s) {
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
  if (child.is_late) return format("stopped after %g s", limit_s);
  const std::string said = last_line(child.output.get());
  if (WIFSIGNALED(status))
    return std::string("crashed: ") + strsignal(WTERMSIG(status)) + (said.empty() ? "" : " (" + said + ")");
  return said.empty() ? format("ended with status %d", WEXITSTATUS(status)) : said;
}

}  // namespace

bool run_in_children(std::size_t count, const ChildLimits& limits, const std::function<void(std::size_t)>& work,
                     const std::function<void(std::size_t, const std::string&)>& ended) {
  const StopSignals signals;
  std::vector<Child> children;
  for (std::size_t next = 0; (next < count || !children.empty()) && stop_asked == 0;) {
    while (next < count && children.size() < limits.side_by_side) children.push_back(start(work, next++));
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    for (std::size_t i = children.size(); i-- > 0 && stop_asked == 0;) {
      Child& child = children[i];
      if (!child.is_late && Seconds(std::chrono::steady_clock::now() - child.begin).count() > limits.seconds) {
        child.is_late = true;
        kill(child.pid, SIGKILL);
      }
      int status = 0;
      if (waitpid(child.pid, &status, WNOHANG) != child.pid) continue;
      const Child gone = std::move(child);
      children.erase(children.begin() + static_cast<std::ptrdiff_t>(i));
      ended(gone.index, failure_of(gone, status, limits.seconds));
    }
  }
  for (const Child& child : children) kill(child.pid, SIGKILL);
  for (const Child& child : children) waitpid(child.pid, nullptr, 0);
  return stop_asked == 0;
}
