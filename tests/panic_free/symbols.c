/* Functions that compiled Rust expects from the platform; declared without types, because they are never called. */
void memcpy(void) {}
void memmove(void) {}
void memset(void) {}
void memcmp(void) {}
void bcmp(void) {}
void rust_eh_personality(void) {}
