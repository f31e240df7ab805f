#pragma once

namespace tandem {

/// Keeps the secrets of this process out of core dumps and from other processes of the same user:
/// it leaves no core, and no debugger attaches. Called before a secret is read, from any thread and
/// any number of times. Has no effect with a sanitizer, which must look into its own process.
void KeepProcessPrivate() noexcept;

/// Has all descriptors but the standard three closed when this process becomes another program: the
/// other program gets no socket, no file and no memory of ours. May be called between fork() and
/// exec(). Who hands on one of them clears its FD_CLOEXEC afterwards.
void CloseOthersOnExec() noexcept;

}  // namespace tandem
