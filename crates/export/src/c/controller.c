/* {{title}}; see the header. Written by armident {{version}}. */
#include "{{header}}"

#include <math.h>

/* driving-axis frames (Lin 1992): distance and offset [m], twist and zero [rad] */
static const double ARM_B[ARM_JOINTS] = { {{b}} };
static const double ARM_D[ARM_JOINTS] = { {{d}} };
static const double ARM_THETA[ARM_JOINTS] = { {{theta}} };
static const double ARM_COS_BETA[ARM_JOINTS] = { {{cos_beta}} };
static const double ARM_SIN_BETA[ARM_JOINTS] = { {{sin_beta}} };
static const int ARM_IS_REVOLUTE[ARM_JOINTS] = { {{is_revolute}} };
/* mass, first moment, and xx, xy, xz, yy, yz, zz of the inertia about the origin of the frame */
static const double ARM_LINK[ARM_JOINTS][10] = {
{{links}}};
/* of rotors [kg m2 or kg] */
static const double ARM_ROTOR[ARM_JOINTS] = { {{rotor}} };
/* recorded effort over true effort */
static const double ARM_GAIN[ARM_JOINTS] = { {{gain}} };
/* speed below which dry friction is linear */
static const double ARM_LINEAR_BELOW[ARM_JOINTS] = { {{linear_below}} };
/* whether some friction depends on the load */
#define ARM_FOLLOWS_LOAD {{follows_load}}
/* in the frame before the first joint [m/s2] */
static const double ARM_GRAVITY[3] = { {{gravity}} };

/* frame i seen from frame i - 1 */
typedef struct {
  double cos_theta, sin_theta, cos_beta, sin_beta;
  double s[3];
} arm_pose;

static inline arm_pose arm_pose_of(int i, double q) {
  arm_pose pose;
  const double theta = ARM_IS_REVOLUTE[i] ? ARM_THETA[i] + q : ARM_THETA[i];
  const double d = ARM_IS_REVOLUTE[i] ? ARM_D[i] : ARM_D[i] + q;
  pose.cos_theta = cos(theta);
  pose.sin_theta = sin(theta);
  pose.cos_beta = ARM_COS_BETA[i];
  pose.sin_beta = ARM_SIN_BETA[i];
  pose.s[0] = ARM_B[i];
  pose.s[1] = -d * pose.sin_beta;
  pose.s[2] = d * pose.cos_beta;
  return pose;
}

static inline void arm_to_child(const arm_pose *pose, const double v[3], double out[3]) {
  const double y = pose->cos_beta * v[1] + pose->sin_beta * v[2];
  const double z = pose->cos_beta * v[2] - pose->sin_beta * v[1];
  out[0] = pose->cos_theta * v[0] + pose->sin_theta * y;
  out[1] = pose->cos_theta * y - pose->sin_theta * v[0];
  out[2] = z;
}

static inline void arm_to_parent(const arm_pose *pose, const double v[3], double out[3]) {
  const double x = pose->cos_theta * v[0] - pose->sin_theta * v[1];
  const double y = pose->sin_theta * v[0] + pose->cos_theta * v[1];
  const double z = v[2];
  out[0] = x;
  out[1] = pose->cos_beta * y - pose->sin_beta * z;
  out[2] = pose->sin_beta * y + pose->cos_beta * z;
}

static inline void arm_cross(const double a[3], const double b[3], double out[3]) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

static inline void arm_add_cross(const double a[3], const double b[3], double sum[3]) {
  double product[3];
  arm_cross(a, b, product);
  sum[0] += product[0];
  sum[1] += product[1];
  sum[2] += product[2];
}

/* inertia xx, xy, xz, yy, yz, zz times v */
static inline void arm_inertia_times(const double inertia[6], const double v[3], double out[3]) {
  out[0] = inertia[0] * v[0] + inertia[1] * v[1] + inertia[2] * v[2];
  out[1] = inertia[1] * v[0] + inertia[3] * v[1] + inertia[4] * v[2];
  out[2] = inertia[2] * v[0] + inertia[4] * v[1] + inertia[5] * v[2];
}

/* recursive Newton-Euler (Luh, Walker, Paul 1980) */
static void arm_rigid(const double q[ARM_JOINTS], const double dq[ARM_JOINTS], const double ddq[ARM_JOINTS],
                      double effort[ARM_JOINTS]) {
  arm_pose pose[ARM_JOINTS];
  double w[ARM_JOINTS + 1][3] = { { 0.0, 0.0, 0.0 } };
  double dw[ARM_JOINTS + 1][3] = { { 0.0, 0.0, 0.0 } };
  double a[ARM_JOINTS + 1][3] = { { -ARM_GRAVITY[0], -ARM_GRAVITY[1], -ARM_GRAVITY[2] } };
  double force[3] = { 0.0, 0.0, 0.0 };
  double moment[3] = { 0.0, 0.0, 0.0 };
  int i, k;
  for (i = 0; i < ARM_JOINTS; i++) {
    double moved[3], turned[3];
    pose[i] = arm_pose_of(i, q[i]);
    arm_cross(dw[i], pose[i].s, moved);
    arm_cross(w[i], pose[i].s, turned);
    arm_add_cross(w[i], turned, moved);
    for (k = 0; k < 3; k++) moved[k] += a[i][k];
    arm_to_child(&pose[i], w[i], w[i + 1]);
    arm_to_child(&pose[i], dw[i], dw[i + 1]);
    arm_to_child(&pose[i], moved, a[i + 1]);
    if (ARM_IS_REVOLUTE[i]) {
      dw[i + 1][0] += w[i + 1][1] * dq[i];
      dw[i + 1][1] -= w[i + 1][0] * dq[i];
      dw[i + 1][2] += ddq[i];
      w[i + 1][2] += dq[i];
    } else {
      a[i + 1][0] += 2.0 * w[i + 1][1] * dq[i];
      a[i + 1][1] -= 2.0 * w[i + 1][0] * dq[i];
      a[i + 1][2] += ddq[i];
    }
  }
  for (i = ARM_JOINTS - 1; i >= 0; i--) {
    const double *link = ARM_LINK[i];
    double turned[3], momentum[3], before[3];
    for (k = 0; k < 3; k++) force[k] += link[0] * a[i + 1][k];
    arm_add_cross(dw[i + 1], link + 1, force);
    arm_cross(w[i + 1], link + 1, turned);
    arm_add_cross(w[i + 1], turned, force);
    arm_inertia_times(link + 4, dw[i + 1], momentum);
    for (k = 0; k < 3; k++) moment[k] += momentum[k];
    arm_inertia_times(link + 4, w[i + 1], momentum);
    arm_add_cross(w[i + 1], momentum, moment);
    arm_add_cross(link + 1, a[i + 1], moment);
    effort[i] = ARM_IS_REVOLUTE[i] ? moment[2] : force[2];
    arm_to_parent(&pose[i], force, before);
    for (k = 0; k < 3; k++) force[k] = before[k];
    arm_to_parent(&pose[i], moment, before);
    for (k = 0; k < 3; k++) moment[k] = before[k];
    arm_add_cross(pose[i].s, force, moment);
  }
}

/* sign of the speed, linear below one */
static inline double arm_direction(double dq, double linear_below) {
  if (fabs(dq) >= linear_below) return dq > 0.0 ? 1.0 : dq < 0.0 ? -1.0 : 0.0;
  return dq / linear_below;
}

{{deflected}}/* efforts beyond the rigid body and its rotors, without the gains of the channels */
static void arm_beyond(arm_memory *memory, const double q[ARM_JOINTS], const double dq[ARM_JOINTS],
                       const double load[ARM_JOINTS], double effort[ARM_JOINTS]) {
  double direction[ARM_JOINTS];
  int i;
  for (i = 0; i < ARM_JOINTS; i++) {
    direction[i] = arm_direction(dq[i], ARM_LINEAR_BELOW[i]);
    effort[i] = 0.0;
  }
{{remember}}{{friction}}  (void)memory;
  (void)q;
  (void)load;
  (void)direction;
}

void arm_inverse_dynamics(arm_memory *memory, const double q[ARM_JOINTS], const double dq[ARM_JOINTS],
                          const double ddq[ARM_JOINTS], double effort[ARM_JOINTS]) {
  double beyond[ARM_JOINTS];
  int i;
  arm_rigid(q, dq, ddq, effort);
  arm_beyond(memory, q, dq, effort, beyond);
  for (i = 0; i < ARM_JOINTS; i++) {
    effort[i] = ARM_GAIN[i] * (effort[i] + ARM_ROTOR[i] * ddq[i] + beyond[i]);
  }
}

void arm_gravity(const double q[ARM_JOINTS], double effort[ARM_JOINTS]) {
  static const double still[ARM_JOINTS] = { 0.0 };
  int i;
  arm_rigid(q, still, still, effort);
  for (i = 0; i < ARM_JOINTS; i++) effort[i] *= ARM_GAIN[i];
}

void arm_friction(arm_memory *memory, const double q[ARM_JOINTS], const double dq[ARM_JOINTS],
                  const double load[ARM_JOINTS], double effort[ARM_JOINTS]) {
  double true_load[ARM_JOINTS];
  int i;
  for (i = 0; i < ARM_JOINTS; i++) true_load[i] = load[i] / ARM_GAIN[i];
  arm_beyond(memory, q, dq, true_load, effort);
  for (i = 0; i < ARM_JOINTS; i++) effort[i] *= ARM_GAIN[i];
}

/* composite bodies, from the last link inwards (Walker, Orin 1982) */
void arm_inertia_matrix(const double q[ARM_JOINTS], double inertia[ARM_JOINTS][ARM_JOINTS]) {
  arm_pose pose[ARM_JOINTS];
  double body[10] = { 0.0 };
  int i, j, k;
  for (i = 0; i < ARM_JOINTS; i++) pose[i] = arm_pose_of(i, q[i]);
  for (i = ARM_JOINTS - 1; i >= 0; i--) {
    double linear[3], angular[3], before[3];
    double rows[3][3], turned[3][3], first[3];
    const double *s = pose[i].s;
    double s_first, s_s;
    for (k = 0; k < 10; k++) body[k] += ARM_LINK[i][k];
    if (ARM_IS_REVOLUTE[i]) {
      linear[0] = -body[2];
      linear[1] = body[1];
      linear[2] = 0.0;
      angular[0] = body[6];
      angular[1] = body[8];
      angular[2] = body[9];
    } else {
      linear[0] = 0.0;
      linear[1] = 0.0;
      linear[2] = body[0];
      angular[0] = body[2];
      angular[1] = -body[1];
      angular[2] = 0.0;
    }
    inertia[i][i] = (ARM_IS_REVOLUTE[i] ? angular[2] : linear[2]) + ARM_ROTOR[i];
    for (j = i - 1; j >= 0; j--) {
      arm_to_parent(&pose[j + 1], linear, before);
      for (k = 0; k < 3; k++) linear[k] = before[k];
      arm_to_parent(&pose[j + 1], angular, before);
      for (k = 0; k < 3; k++) angular[k] = before[k];
      arm_add_cross(pose[j + 1].s, linear, angular);
      inertia[i][j] = inertia[j][i] = ARM_IS_REVOLUTE[j] ? angular[2] : linear[2];
    }
    /* the composite body about the origin of the frame before */
    rows[0][0] = body[4];
    rows[0][1] = rows[1][0] = body[5];
    rows[0][2] = rows[2][0] = body[6];
    rows[1][1] = body[7];
    rows[1][2] = rows[2][1] = body[8];
    rows[2][2] = body[9];
    for (k = 0; k < 3; k++) arm_to_parent(&pose[i], rows[k], turned[k]);
    for (k = 0; k < 3; k++) {
      const double column[3] = { turned[0][k], turned[1][k], turned[2][k] };
      arm_to_parent(&pose[i], column, rows[k]);
    }
    arm_to_parent(&pose[i], body + 1, first);
    s_first = s[0] * first[0] + s[1] * first[1] + s[2] * first[2];
    s_s = s[0] * s[0] + s[1] * s[1] + s[2] * s[2];
    for (j = 0; j < 3; j++) {
      for (k = 0; k < 3; k++) rows[j][k] -= s[j] * first[k] + first[j] * s[k] + body[0] * s[j] * s[k];
      rows[j][j] += 2.0 * s_first + body[0] * s_s;
    }
    body[4] = rows[0][0];
    body[5] = rows[0][1];
    body[6] = rows[0][2];
    body[7] = rows[1][1];
    body[8] = rows[1][2];
    body[9] = rows[2][2];
    for (k = 0; k < 3; k++) body[1 + k] = first[k] + body[0] * s[k];
  }
}

/* generalised momentum, and the derivative of the kinetic energy by the position */
static void arm_momentum(const double q[ARM_JOINTS], const double dq[ARM_JOINTS], double momentum[ARM_JOINTS],
                         double derivative[ARM_JOINTS]) {
  arm_pose pose[ARM_JOINTS];
  double w[ARM_JOINTS + 1][3] = { { 0.0, 0.0, 0.0 } };
  double v[ARM_JOINTS + 1][3] = { { 0.0, 0.0, 0.0 } };
  /* of the frame before, in this one */
  double w_before[ARM_JOINTS][3], v_before[ARM_JOINTS][3];
  double linear[3] = { 0.0, 0.0, 0.0 };
  double angular[3] = { 0.0, 0.0, 0.0 };
  int i, k;
  for (i = 0; i < ARM_JOINTS; i++) {
    double moved[3];
    pose[i] = arm_pose_of(i, q[i]);
    arm_cross(w[i], pose[i].s, moved);
    for (k = 0; k < 3; k++) moved[k] += v[i][k];
    arm_to_child(&pose[i], w[i], w_before[i]);
    arm_to_child(&pose[i], moved, v_before[i]);
    for (k = 0; k < 3; k++) {
      w[i + 1][k] = w_before[i][k];
      v[i + 1][k] = v_before[i][k];
    }
    if (ARM_IS_REVOLUTE[i]) w[i + 1][2] += dq[i];
    else v[i + 1][2] += dq[i];
  }
  for (i = ARM_JOINTS - 1; i >= 0; i--) {
    const double *link = ARM_LINK[i];
    double turned[3], before[3];
    for (k = 0; k < 3; k++) linear[k] += link[0] * v[i + 1][k];
    arm_add_cross(w[i + 1], link + 1, linear);
    arm_inertia_times(link + 4, w[i + 1], turned);
    for (k = 0; k < 3; k++) angular[k] += turned[k];
    arm_add_cross(link + 1, v[i + 1], angular);
    /* momentum times the motion of the frame before crossed with the axis */
    if (ARM_IS_REVOLUTE[i]) {
      momentum[i] = angular[2];
      derivative[i] = angular[0] * w_before[i][1] - angular[1] * w_before[i][0] + linear[0] * v_before[i][1] -
                      linear[1] * v_before[i][0];
    } else {
      momentum[i] = linear[2];
      derivative[i] = linear[0] * w_before[i][1] - linear[1] * w_before[i][0];
    }
    momentum[i] += ARM_ROTOR[i] * dq[i];
    arm_to_parent(&pose[i], linear, before);
    for (k = 0; k < 3; k++) linear[k] = before[k];
    arm_to_parent(&pose[i], angular, before);
    for (k = 0; k < 3; k++) angular[k] = before[k];
    arm_add_cross(pose[i].s, linear, angular);
  }
}

void arm_observe(arm_observer *observer, arm_memory *memory, double gain, double dt, const double q[ARM_JOINTS],
                 const double dq[ARM_JOINTS], const double effort[ARM_JOINTS]) {
  static const double still[ARM_JOINTS] = { 0.0 };
  double momentum[ARM_JOINTS], derivative[ARM_JOINTS], gravity[ARM_JOINTS], load[ARM_JOINTS], beyond[ARM_JOINTS];
  int i;
  arm_momentum(q, dq, momentum, derivative);
  arm_rigid(q, still, still, gravity);
  /* friction that depends on the load: that of the motion without its acceleration */
  if (ARM_FOLLOWS_LOAD) arm_rigid(q, dq, still, load);
  else for (i = 0; i < ARM_JOINTS; i++) load[i] = gravity[i];
  arm_beyond(memory, q, dq, load, beyond);
  for (i = 0; i < ARM_JOINTS; i++) {
    const double by_motor = effort[i] / ARM_GAIN[i] - beyond[i] - gravity[i] + derivative[i];
    const double by_surroundings = observer->residual[i] / ARM_GAIN[i];
    if (!observer->is_set) observer->integral[i] = momentum[i];
    else observer->integral[i] += (by_motor + by_surroundings) * dt;
    observer->residual[i] = ARM_GAIN[i] * gain * (momentum[i] - observer->integral[i]);
  }
  observer->is_set = 1;
}
{{alarm}}