/* The library for C, by a program in C99 whose allocator ends it once the estimator is made: a recording gives the
 * distances of the truth, wrong input its status and text, and a caller of another version is served. */
#include "plumbline.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "recorded.h"

static int is_forbidden = 0;

/* What glibc has beneath the functions that are replaced. */
extern void* __libc_malloc(size_t);
extern void* __libc_calloc(size_t, size_t);
extern void* __libc_realloc(void*, size_t);
extern void* __libc_memalign(size_t, size_t);

static void check_allowed(void) {
  if (is_forbidden) abort();
}
void* malloc(size_t size) {
  check_allowed();
  return __libc_malloc(size);
}
void* calloc(size_t count, size_t size) {
  check_allowed();
  return __libc_calloc(count, size);
}
void* realloc(void* memory, size_t size) {
  check_allowed();
  return __libc_realloc(memory, size);
}
void* memalign(size_t alignment, size_t size) {
  check_allowed();
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(size_t alignment, size_t size) { return memalign(alignment, size); }
int posix_memalign(void** out, size_t alignment, size_t size) {
  *out = memalign(alignment, size);
  return *out == NULL;
}

static int failures = 0;
#define CHECK(condition)                                             \
  do {                                                               \
    if (!(condition)) {                                              \
      fprintf(stderr, "FAILED line %d: %s\n", __LINE__, #condition); \
      ++failures;                                                    \
    }                                                                \
  } while (0)

static plumbline_config simple_config(void) {
  plumbline_config config = PLUMBLINE_CONFIG_INIT;
  const double intrinsics[4] = {400, 400, 320, 240};
  config.width = 640;
  config.height = 480;
  memcpy(config.intrinsics, intrinsics, sizeof intrinsics);
  config.T_body_camera[0] = config.T_body_camera[5] = config.T_body_camera[10] = config.T_body_camera[15] = 1;
  config.gyro_density = config.gyro_walk = 1e-4;
  config.accel_density = config.accel_walk = 1e-3;
  config.imu_rate_hz = 200;
  return config;
}

static void check_wrong_input(char* memory, size_t size) {
  plumbline_estimator* estimator = NULL;
  plumbline_config config = simple_config();
  CHECK(plumbline_create(NULL, size, &config, &estimator) == PLUMBLINE_NULL_POINTER);
  CHECK(plumbline_create(memory, size, NULL, &estimator) == PLUMBLINE_NULL_POINTER);
  CHECK(plumbline_create(memory, plumbline_estimator_size() - 1, &config, &estimator) == PLUMBLINE_MEMORY_TOO_SMALL);
  config.struct_size = 0;
  CHECK(plumbline_create(memory, size, &config, &estimator) == PLUMBLINE_STRUCT_SIZE);
  config = simple_config();
  config.camera_model = 9;
  CHECK(plumbline_create(memory, size, &config, &estimator) == PLUMBLINE_BAD_CAMERA);
  config = simple_config();
  config.intrinsics[2] = NAN;
  CHECK(plumbline_create(memory, size, &config, &estimator) == PLUMBLINE_BAD_CAMERA);
  config = simple_config();
  config.width = config.height = 2147483647;
  CHECK(plumbline_create(memory, size, &config, &estimator) == PLUMBLINE_IMAGE_TOO_LARGE);
  config = simple_config();
  config.T_body_camera[0] = -1;
  CHECK(plumbline_create(memory, size, &config, &estimator) == PLUMBLINE_BAD_TRANSFORM);
  config = simple_config();
  config.accel_walk = 0;
  CHECK(plumbline_create(memory, size, &config, &estimator) == PLUMBLINE_BAD_NOISE);
  CHECK(estimator == NULL);

  config = simple_config();
  CHECK(plumbline_create(memory, size, &config, &estimator) == PLUMBLINE_OK);
  plumbline_state state = PLUMBLINE_STATE_INIT;
  CHECK(plumbline_get_state(estimator, &state) == PLUMBLINE_NOT_INITIALIZED);
  state.struct_size = 8;
  CHECK(plumbline_get_state(estimator, &state) == PLUMBLINE_STRUCT_SIZE);
  plumbline_imu_sample sample = PLUMBLINE_IMU_SAMPLE_INIT;
  sample.t_ns = 1000;
  CHECK(plumbline_add_imu(estimator, &sample) == PLUMBLINE_OK);
  sample.gyro[1] = NAN;
  sample.t_ns = 2000;
  CHECK(plumbline_add_imu(estimator, &sample) == PLUMBLINE_NOT_FINITE);
  static unsigned char pixels[640 * 480];
  plumbline_frame frame = PLUMBLINE_FRAME_INIT;
  CHECK(plumbline_add_frame(estimator, &frame) == PLUMBLINE_NULL_POINTER);
  frame.gray = pixels;
  frame.width = 640;
  frame.height = 400;
  frame.gray_stride = 640;
  CHECK(plumbline_add_frame(estimator, &frame) == PLUMBLINE_WRONG_IMAGE_SIZE);
  frame.height = 480;
  frame.gray_stride = 639;
  CHECK(plumbline_add_frame(estimator, &frame) == PLUMBLINE_WRONG_IMAGE_SIZE);
  plumbline_destroy(estimator);
  plumbline_destroy(NULL);

  CHECK(strcmp(plumbline_status_text(PLUMBLINE_WRONG_IMAGE_SIZE), "wrong image size") == 0);
  CHECK(strcmp(plumbline_status_text(99), "unknown status") == 0);
  for (int status = 20; status <= 28; ++status) CHECK(strcmp(plumbline_status_text(status), "unknown status") != 0);
  CHECK(strcmp(plumbline_health_text(PLUMBLINE_TRACKING), "tracking") == 0);
  CHECK(strcmp(plumbline_reason_text(2), "few inliers") == 0);
}

/* A caller that was compiled with a later header, whose structs are longer. */
static void check_later_caller(char* memory, size_t size) {
  struct {
    plumbline_config known;
    char later[64];
  } config;
  struct {
    plumbline_state known;
    char later[64];
  } state;
  memset(&config, 0x5A, sizeof config);
  memset(&state, 0x5A, sizeof state);
  config.known = simple_config();
  config.known.struct_size = sizeof config;
  plumbline_estimator* estimator = NULL;
  CHECK(plumbline_create(memory, size, &config.known, &estimator) == PLUMBLINE_OK);
  static unsigned char pixels[640 * 480];
  plumbline_frame frame = PLUMBLINE_FRAME_INIT;
  frame.t_ns = 5000000;
  frame.gray = pixels;
  frame.width = 640;
  frame.height = 480;
  frame.gray_stride = 640;
  CHECK(plumbline_add_frame(estimator, &frame) == PLUMBLINE_OK);
  CHECK(plumbline_add_frame(estimator, &frame) == PLUMBLINE_LATE_SAMPLE);
  state.known.struct_size = sizeof state;
  CHECK(plumbline_get_state(estimator, &state.known) == PLUMBLINE_OK);
  CHECK(state.known.t_ns == 5000000);
  CHECK(state.known.struct_size == sizeof state);
  for (size_t i = 0; i < sizeof state.later; ++i) CHECK(state.later[i] == 0x5A);
  plumbline_destroy(estimator);
}

static void check_recording(const struct recorded* recording, char* memory, size_t size) {
  plumbline_estimator* estimator = NULL;
  const plumbline_status status = plumbline_create(memory, size, &recording->config, &estimator);
  if (status != PLUMBLINE_OK) fprintf(stderr, "%s\n", plumbline_status_text(status));
  CHECK(status == PLUMBLINE_OK);
  if (estimator == NULL) return;
  is_forbidden = 1;
  plumbline_state first = PLUMBLINE_STATE_INIT, last = PLUMBLINE_STATE_INIT;
  int tracking = 0;
  for (int i = 0; i < recording->count; ++i) {
    plumbline_imu_sample sample;
    plumbline_frame frame;
    recorded_item(i, &sample, &frame);
    if (frame.gray == NULL) {
      CHECK(plumbline_add_imu(estimator, &sample) == PLUMBLINE_OK);
      continue;
    }
    CHECK(plumbline_add_frame(estimator, &frame) == PLUMBLINE_OK);
    CHECK(plumbline_get_state(estimator, &last) == PLUMBLINE_OK);
    CHECK(last.t_ns == frame.t_ns);
    if (last.health == PLUMBLINE_TRACKING && tracking++ == 0) first = last;
  }
  is_forbidden = 0;
  double distance = 0, norm = 0;
  for (int i = 0; i < 3; ++i) {
    const double step = last.p_world_body[i] - first.p_world_body[i];
    distance += step * step;
  }
  for (int i = 0; i < 4; ++i) norm += last.q_world_body[i] * last.q_world_body[i];
  distance = sqrt(distance);
  const double truth = recorded_distance(first.t_ns, last.t_ns);
  printf("%d frames tracking, distance %.3f m, truth %.3f m\n", tracking, distance, truth);
  CHECK(tracking > 20);
  CHECK(truth > 0.2);
  CHECK(fabs(distance - truth) < 0.05 * truth);
  CHECK(fabs(norm - 1) < 1e-9);
  CHECK(last.covariance[0] > 0 && last.covariance[35] > 0);
  CHECK(plumbline_reset(estimator) == PLUMBLINE_OK);
  plumbline_destroy(estimator);
}

int main(int argc, char** argv) {
  CHECK(plumbline_abi_version() == PLUMBLINE_ABI_VERSION);
  CHECK(strcmp(plumbline_configuration(), "mono-imu/points/window") == 0);
  const size_t size = plumbline_estimator_size();
  char* memory = malloc(size + 1);
  if (memory == NULL) return 1;
  if (argc == 2) {
    static struct recorded recording;
    if (!recorded_open(argv[1], 10, &recording)) return 77;
    check_recording(&recording, memory + 1, size); /* at an odd address */
  } else {
    printf("%zu bytes\n", size);
    is_forbidden = 1;
    check_wrong_input(memory, size);
    check_later_caller(memory, size);
    is_forbidden = 0;
  }
  free(memory);
  if (failures == 0) puts("passed");
  return failures != 0;
}
