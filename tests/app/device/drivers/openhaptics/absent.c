/* Stands for a library that another one needs, and that the loader does not find. */
int absent(void);
int absent(void) {
  return 0;
}
