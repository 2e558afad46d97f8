float broken() {
  float fine = 1.0;
  return fine + no_such_name;
}
