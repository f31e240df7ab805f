#include "app/process/become_program.h"

#include <cerrno>
#include <cstring>

#include <unistd.h>

#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/program_folders.h"
#include "engine/realtime/private_process.h"

namespace tandem {

int BecomeProgram(const std::string& name, const std::vector<std::string>& arguments) {
  const std::string program = (ProgramFolder() / name).string();
  std::vector<char*> argv{const_cast<char*>(program.c_str())};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  CloseOthersOnExec();
  execv(program.c_str(), argv.data());
  return Fail(kExitFailed, program + " cannot be started: " + std::strerror(errno));
}

}  // namespace tandem
