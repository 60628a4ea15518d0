/* What compiled Rust expects of the platform; declared without types, for it is never called. */
void memcpy(void) {}
void memmove(void) {}
void memset(void) {}
void memcmp(void) {}
void bcmp(void) {}
void rust_eh_personality(void) {}
