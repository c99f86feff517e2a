//! Time of one call of the C source of a controller, compiled with `cc -O2`: processor time, least of 300 runs.

#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "a bench prints and may panic")]

use std::path::Path;
use std::process::Command;

use armident_export::controller;
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, load_urdf};
use armident_model::ArmModel;

const MAIN: &str = r#"#define _POSIX_C_SOURCE 199309L
#include <stdio.h>
#include <time.h>
#include "panda.h"
enum { CALLS = 5000, RUNS = 300 };
static double now_ns(void) {
  struct timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}
#define TIME(name, call) do { \
    double least = 1e30; \
    int run, k; \
    for (run = 0; run < RUNS; run++) { \
      double start = now_ns(), took; \
      for (k = 0; k < CALLS; k++) { q[0] += 1e-6; call; sum += effort[0]; } \
      took = (now_ns() - start) / CALLS; \
      if (took < least) least = took; \
    } \
    printf("%-18s %5.0f ns\n", name, least); \
  } while (0)
int main(void) {
  static panda_memory memory;
  static panda_observer observer;
  double q[7], dq[7], ddq[7], effort[7], inertia[7][7], sum = 0.0;
  int j;
  for (j = 0; j < 7; j++) { q[j] = 0.1 * j; dq[j] = 0.3 - 0.1 * j; ddq[j] = 0.2 * j; }
  TIME("inverse dynamics", panda_inverse_dynamics(&memory, q, dq, ddq, effort));
  TIME("gravity", panda_gravity(q, effort));
  TIME("inertia matrix", panda_inertia_matrix(q, inertia); effort[0] = inertia[0][0]);
  TIME("observer", panda_observe(&observer, &memory, 30.0, 1e-3, q, dq, ddq); effort[0] = observer.residual[0]);
  return sum == 0.5;
}
"#;

fn main() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../urdf/panda.urdf");
    let robot = load_urdf(&path).unwrap();
    let chain = SerialChain::from_description(&robot, &ChainSelection::default()).unwrap();
    let exported = controller(&ArmModel::from_chain(DrivingAxisChain::from_chain(&chain)));
    let header = exported.companion.unwrap();
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("controller_bench");
    std::fs::create_dir_all(&folder).unwrap();
    let files = [("main.c", MAIN), (&header.file, &header.text), ("panda.c", &exported.text)];
    for (name, text) in files {
        std::fs::write(folder.join(name), text).unwrap();
    }
    let compiler = ["-std=c99", "-O2", "main.c", "panda.c", "-lm", "-o", "main"];
    let compiled = Command::new("cc").args(compiler).current_dir(&folder).status().unwrap();
    assert!(compiled.success());
    assert!(Command::new(folder.join("main")).status().unwrap().success());
}
