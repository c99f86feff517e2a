/* {{title}}
 *
 * Written by armident {{version}}. C99, no allocation, no library but libm. SI units: rad, rad/s, N m (m, m/s, N of prismatic
 * joints). Arrays have ARM_JOINTS entries, in this order:
{{joints}} *
 * Efforts are those of the recorded effort channels: their gains are part of the model.
{{notes}} */
#ifndef ARM_H
#define ARM_H

#ifdef __cplusplus
extern "C" {
#endif

#define ARM_JOINTS {{dof}}
#define ARM_MEMORIES {{memories}}

/* What dry friction remembers of the travel. Start with all bytes zero. */
typedef struct {
  double deflection[ARM_MEMORIES > 0 ? ARM_MEMORIES : 1];
  double position[ARM_JOINTS];
  int is_set;
} arm_memory;

/* Momentum observer (De Luca, Mattone 2003). Start with all bytes zero. */
typedef struct {
  double integral[ARM_JOINTS];
  double residual[ARM_JOINTS]; /* effort of the surroundings, as the effort channels would show it */
  int is_set;
} arm_observer;

/* Effort of a motion: rigid body, rotors, friction and all else that is listed above. */
void arm_inverse_dynamics(arm_memory *memory, const double q[ARM_JOINTS], const double dq[ARM_JOINTS],
                          const double ddq[ARM_JOINTS], double effort[ARM_JOINTS]);

/* Effort that holds the rigid body in a position. */
void arm_gravity(const double q[ARM_JOINTS], double effort[ARM_JOINTS]);

/* Effort beyond the rigid body; load is the effort of the rigid body, on which some friction depends. */
void arm_friction(arm_memory *memory, const double q[ARM_JOINTS], const double dq[ARM_JOINTS],
                  const double load[ARM_JOINTS], double effort[ARM_JOINTS]);

/* Inertia matrix with the rotors, symmetric, row by row, in true efforts: the gains of the effort channels are no part of it. */
void arm_inertia_matrix(const double q[ARM_JOINTS], double inertia[ARM_JOINTS][ARM_JOINTS]);

/* One step of dt [s] of the observer, whose residual follows the effort of the surroundings with a bandwidth of gain [1/s]. */
void arm_observe(arm_observer *observer, arm_memory *memory, double gain, double dt, const double q[ARM_JOINTS],
                 const double dq[ARM_JOINTS], const double effort[ARM_JOINTS]);
{{alarm_header}}
#ifdef __cplusplus
}
#endif

#endif
