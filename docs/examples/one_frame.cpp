// one_frame SCENE: a hand presses the scene's first moving body down by 10 mm in half a second, frame by frame.
#include <cstdio>

#include <tandem/engine/geometry/import/mesh_file.h>
#include <tandem/engine/world/world.h>

int main(int argc, char** argv) {
  tandem::RunImportHelperIfAsked(argc, argv);  // mesh files are read in a child process of our own
  if (argc != 2) return std::fprintf(stderr, "usage: one_frame SCENE\n"), 2;
  const tandem::Result<tandem::Scene> scene = tandem::LoadScene(argv[1]);
  if (!scene) return std::fprintf(stderr, "%s\n", scene.error().what.c_str()), 3;
  const auto model = tandem::LoadWorld(*scene);  // reads, weighs and voxelizes the meshes
  if (!model) return std::fprintf(stderr, "%s\n", model.error().what.c_str()), 3;
  const tandem::BodyModel& body = (*model)->bodies.at(0);

  tandem::kHapticThread.Enter();
  tandem::World world(*model);
  tandem::StepInputs inputs = tandem::ParkedInputs(**model);
  inputs.instances[0].drive = tandem::BodyDrive::kSimulated;
  inputs.hand.body = 0;
  inputs.hand.goal.X_WA = body.X_WB0;  // where a haptic device would say that it is
  inputs.hand.gains = tandem::DefaultHandGains(body.inertia);
  std::printf("frame  body_mm  hand_N  contacts\n");
  for (int frame = 0; frame <= 1000; ++frame) {
    inputs.hand.goal.X_WA.p.z() = body.X_WB0.p.z() - 0.01 * (frame < 500 ? frame / 500.0 : 1);
    const tandem::StepReport& report = world.Step(inputs);
    const double down = world.state(0).X_WB.p.z() - body.X_WB0.p.z();
    if (frame % 100 == 0) {
      std::printf("%5d %8.3f %7.3f %9d\n", frame, 1000 * down, -report.hand_B_W.f.z(),
                  report.contact_points);
    }
  }
}
