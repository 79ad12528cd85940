// An estimator of a global-shutter camera and points, with nothing else: check_symbols.cmake looks for what is absent.
#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/estimator/estimator.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/sensor/mono.hpp"

namespace pl = plumbline;

using Sensors = pl::Rig<pl::Mono<pl::Pinhole<float>, 320 * 240>>;
using Vo = pl::Estimator<Sensors, pl::Features<pl::Points<60>>, pl::SlidingWindow<5>>;

template class plumbline::Estimator<Sensors, pl::Features<pl::Points<60>>, pl::SlidingWindow<5>>;

bool use(Vo& vo, const Vo::Frame& frame) { return bool(vo.add_frame(frame)); }
