/* plumbline for C99 and whatever calls it: one estimator, chosen when the library is built, in memory that the caller
 * gives. Nothing is allocated, neither at creation nor later; no function blocks, prints or keeps a global state.
 *
 *   size_t size = plumbline_estimator_size();
 *   plumbline_config config = PLUMBLINE_CONFIG_INIT;          (then the calibration)
 *   plumbline_create(memory, size, &config, &estimator);
 *   plumbline_add_imu(estimator, &sample);
 *   plumbline_add_frame(estimator, &frame);
 *   plumbline_get_state(estimator, &state);
 *
 * Each struct begins with its size as its user was compiled with: members are only ever added at the end, so that an old
 * caller works with a new library. Members that are not set are zero and mean the default.     docs/guide/c.md */
#ifndef PLUMBLINE_H
#define PLUMBLINE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Of this header; 1 is added where members or functions are. */
#define PLUMBLINE_ABI_VERSION 1

typedef struct plumbline_estimator plumbline_estimator;

typedef int32_t plumbline_status;
enum {
  PLUMBLINE_OK = 0,
  PLUMBLINE_LATE_SAMPLE = 1,      /* time stamp not after the one before */
  PLUMBLINE_WRONG_IMAGE_SIZE = 2, /* not that of the calibration, or rows shorter than the image is wide */
  PLUMBLINE_NOT_FINITE = 3,       /* NaN or infinity in a sample */
  PLUMBLINE_TOO_FEW_FEATURES = 4,
  PLUMBLINE_NOT_POSITIVE_DEFINITE = 5,
  PLUMBLINE_NOT_INITIALIZED = 6, /* no estimate yet */
  PLUMBLINE_NULL_POINTER = 20,
  PLUMBLINE_STRUCT_SIZE = 21, /* struct_size is none of any version */
  PLUMBLINE_MEMORY_TOO_SMALL = 22,
  PLUMBLINE_IMAGE_TOO_LARGE = 23, /* for the pixels that the library was built for */
  PLUMBLINE_BAD_CAMERA = 24,      /* model, intrinsics or size */
  PLUMBLINE_BAD_TRANSFORM = 25,   /* T_body_camera is no rotation and translation */
  PLUMBLINE_BAD_NOISE = 26,       /* a noise density or rate is not positive */
  PLUMBLINE_BAD_DEPTH = 27,       /* depth units per meter are not positive */
  PLUMBLINE_NO_SUCH_SENSOR = 28   /* the library was built without an IMU */
};

enum { PLUMBLINE_PINHOLE = 0, PLUMBLINE_RADTAN = 1, PLUMBLINE_EQUIDISTANT = 2, PLUMBLINE_DOUBLE_SPHERE = 3 };

typedef struct plumbline_config {
  uint32_t struct_size;
  int32_t camera_model;     /* PLUMBLINE_PINHOLE ... */
  int32_t width, height;    /* [px] */
  double intrinsics[4];     /* fx fy cx cy [px] */
  double parameters[5];     /* radtan: k1 k2 p1 p2 k3; equidistant: k1 k2 k3 k4; double sphere: xi alpha */
  double T_body_camera[16]; /* row by row: camera into body (= IMU) coordinates; with an IMU */
  double gyro_density;      /* [rad/s/sqrt(Hz)]; with an IMU, as those below */
  double accel_density;     /* [m/s^2/sqrt(Hz)] */
  double gyro_walk;         /* [rad/s^2/sqrt(Hz)] */
  double accel_walk;        /* [m/s^3/sqrt(Hz)] */
  double imu_rate_hz;
  double gyro_full_scale;       /* [rad/s]; 0: 34.9 */
  double accel_full_scale;      /* [m/s^2]; 0: 156.9 */
  double time_offset_s;         /* t_imu = t_image + offset */
  double depth_units_per_meter; /* with depth */
} plumbline_config;

typedef struct plumbline_imu_sample {
  uint32_t struct_size;
  uint32_t reserved;
  int64_t t_ns;
  double gyro[3];  /* [rad/s] */
  double accel[3]; /* [m/s^2]; (0, 0, 9.81) where it lies level and still */
} plumbline_imu_sample;

/* The pixels are not used after the call. A stride is the distance of two rows in bytes. */
typedef struct plumbline_frame {
  uint32_t struct_size;
  int32_t width, height;
  uint32_t reserved;
  int64_t t_ns;
  const uint8_t* gray;
  size_t gray_stride;
  const uint16_t* depth; /* with depth; 0: no measurement */
  size_t depth_stride;
} plumbline_frame;

enum { PLUMBLINE_INITIALIZING = 0, PLUMBLINE_TRACKING = 1, PLUMBLINE_DEGRADED = 2, PLUMBLINE_LOST = 3 };

typedef struct plumbline_state {
  uint32_t struct_size;
  int32_t health; /* PLUMBLINE_INITIALIZING ... */
  int32_t reason; /* text: plumbline_reason_text */
  int32_t tracked, is_keyframe;
  uint32_t resets;
  int64_t t_ns;           /* of the latest image */
  double p_world_body[3]; /* [m]; without an IMU the body is the camera */
  double q_world_body[4]; /* x y z w */
  double covariance[36];  /* row by row, of (rotation, position), increments in the body [rad, m] */
  double v_world_body[3]; /* [m/s]; with an IMU, as those below */
  double bias_gyro[3];    /* [rad/s] */
  double bias_accel[3];   /* [m/s^2] */
  double time_offset_s;
} plumbline_state;

#define PLUMBLINE_CONFIG_INIT \
  { sizeof(plumbline_config), 0, 0, 0, {0}, {0}, {0}, 0, 0, 0, 0, 0, 0, 0, 0, 0 }
#define PLUMBLINE_IMU_SAMPLE_INIT                  \
  {                                                \
    sizeof(plumbline_imu_sample), 0, 0, {0}, { 0 } \
  }
#define PLUMBLINE_FRAME_INIT \
  { sizeof(plumbline_frame), 0, 0, 0, 0, NULL, 0, NULL, 0 }
#define PLUMBLINE_STATE_INIT \
  { sizeof(plumbline_state), 0, 0, 0, 0, 0, 0, {0}, {0}, {0}, {0}, {0}, {0}, 0 }

/* Of the library, which may be newer than the header. */
int32_t plumbline_abi_version(void);
/* What it was built for: "mono-imu/points/window", and the most pixels of an image. */
const char* plumbline_configuration(void);
size_t plumbline_max_pixels(void);

/* Bytes that an estimator needs, at any address. */
size_t plumbline_estimator_size(void);
/* Makes an estimator in `memory`, which must stay where it is until plumbline_destroy. */
plumbline_status plumbline_create(void* memory, size_t size, const plumbline_config* config, plumbline_estimator** out);
void plumbline_destroy(plumbline_estimator* estimator);

/* Before a frame come all samples up to its time. After an error the estimator is as it was before. */
plumbline_status plumbline_add_imu(plumbline_estimator* estimator, const plumbline_imu_sample* sample);
plumbline_status plumbline_add_frame(plumbline_estimator* estimator, const plumbline_frame* frame);
/* As of the latest frame; `struct_size` of `out` must be set. */
plumbline_status plumbline_get_state(const plumbline_estimator* estimator, plumbline_state* out);
/* The next frame begins with a new world. */
plumbline_status plumbline_reset(plumbline_estimator* estimator);

/* One line, what is wrong and what is expected; never NULL. */
const char* plumbline_status_text(plumbline_status status);
const char* plumbline_health_text(int32_t health);
const char* plumbline_reason_text(int32_t reason);

#ifdef __cplusplus
}
#endif
#endif
